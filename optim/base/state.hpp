#pragma once
// Named training state, the content of a checkpoint.
#include <cstring>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/device/runtime/real_buffer.hpp"

namespace simuli {

/// A list of named states. Buffers and values belong to the caller and must outlive it.
class StateList {
 public:
  using Bytes = std::vector<std::byte>;
  using Save = std::function<Bytes()>;
  using Load = std::function<void(const std::string& file, std::span<const std::byte>)>;

  void add(std::string name, Save save, Load load);
  /// Loading sets the buffer's count to the saved one.
  void add(std::string name, RealBuffer& buffer);
  void add(std::string name, Buffer<std::uint32_t>& buffer);
  /// A value without pointers.
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void add(const std::string& name, T& value) {
    add(
        name,
        [&value] {
          Bytes bytes(sizeof(T));
          std::memcpy(bytes.data(), &value, sizeof(T));
          return bytes;
        },
        [&value, name](const std::string& file, std::span<const std::byte> bytes) {
          need_size(file, name, bytes.size(), sizeof(T));
          std::memcpy(&value, bytes.data(), sizeof(T));
        });
  }
  /// Numbers read by `get` and restored by `set`; loading requires the number that `get` returns.
  void add_numbers(const std::string& name,
                   const std::function<std::vector<double>()>& get,
                   const std::function<void(std::span<const double>)>& set);
  /// Text that must be equal when loading (need_text).
  void add_fixed(const std::string& name, const std::string& text);

  /// Returns a hash of each state's bytes by name; equal for equal lists.
  [[nodiscard]] std::vector<std::pair<std::string, std::uint64_t>> hashes() const;

  /// Atomic (io/base/state_file.hpp).
  void write(const std::filesystem::path& file) const;
  /// Throws Error{kInput} when the file's blocks differ from the list's, or one is damaged.
  void read(const std::filesystem::path& file) const;

  /// Throws Error{kInput} with the first line in which the text saved as `name` differs from `text`.
  static void need_text(const std::string& file,
                        const std::string& name,
                        std::span<const std::byte> saved,
                        const std::string& text);

 private:
  static void need_size(const std::string& file,
                        const std::string& name,
                        std::size_t found,
                        std::size_t allowed);
  struct Entry {
    std::string name;
    Save save;
    Load load;
  };
  std::vector<Entry> entries_;
};

}  // namespace simuli
