#pragma once
// Ranks that share the training of one scene: MPI processes, or threads with a device each.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"

namespace simuli {

/// Leaves new elements uninitialised: messages have megabytes and are overwritten.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UnsetAllocator<U>;
  };
  template <class U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
  }
};

/// One rank. All ranks make the same calls in the same order.
class Ranks {
 public:
  using Bytes = std::vector<std::byte, UnsetAllocator<std::byte>>;

  Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  virtual ~Ranks() = default;

  [[nodiscard]] virtual std::size_t rank() const = 0;  // from 0
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// Returns the message of each rank, by rank, unchanged. The span is valid until this rank's next call, and
  /// its own part as long as the caller's memory. Throws when another rank has failed.
  using Message = std::span<const std::byte>;
  [[nodiscard]] virtual std::span<const Message> all_gather(Message own) = 0;

  /// Whether the value is true on any rank.
  [[nodiscard]] bool any(bool own);
  /// Returns the value of rank 0.
  [[nodiscard]] bool first(bool own);
  /// Returns when all ranks have called it.
  void wait_for_all();
  [[nodiscard]] bool is_first() const { return rank() == 0; }
};

/// A training without other ranks.
[[nodiscard]] Ranks& one_rank();

/// A property that must be equal on all ranks: "device" and its name, ...
struct RankField {
  std::string name;
  std::string value;
};
/// Ranks whose properties would give different bits. Thrown on all ranks with the same text.
class RanksDiffer : public Error {
 public:
  explicit RanksDiffer(const std::string& what) : Error(ErrorKind::kDevice, what) {}
};
/// Throws RanksDiffer, "rank 2: driver: found FOUND, expected EXPECTED of rank 0", for the first rank that
/// differs from rank 0.
void need_same(Ranks& ranks, const std::vector<RankField>& fields);

/// Serialises values without pointers into a message.
class RankWriter {
 public:
  RankWriter() = default;
  /// Reuses the memory of an earlier message.
  explicit RankWriter(Ranks::Bytes&& memory) : bytes_(std::move(memory)) { bytes_.clear(); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const std::vector<T>& values) {
    const std::span<T> room = this->room<T>(values.size());
    if (!values.empty()) std::memcpy(room.data(), values.data(), room.size_bytes());
  }
  /// Reserves `count` values to be written before the next call. They are aligned for T if all preceding data
  /// have sizes that are multiples of sizeof(T).
  template <class T>
  requires std::is_trivially_copyable_v<T>
  [[nodiscard]] std::span<T> room(std::size_t count) {
    const std::uint64_t number = count;
    const std::size_t at = bytes_.size() + sizeof number;
    bytes_.resize(at + count * sizeof(T));
    std::memcpy(bytes_.data() + at - sizeof number, &number, sizeof number);
    return {reinterpret_cast<T*>(bytes_.data() + at), count};
  }
  void put(const std::string& text) { put(std::vector<char>(text.begin(), text.end())); }
  [[nodiscard]] Ranks::Bytes take() { return std::move(bytes_); }

 private:
  Ranks::Bytes bytes_;
};

/// Reads the values of a RankWriter in order. Throws Error{kInternal} for other bytes.
class RankReader {
 public:
  explicit RankReader(std::span<const std::byte> bytes) : left_(bytes) {}
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get(std::vector<T>& values) {
    const std::size_t count = taken_count(sizeof(T));
    values.resize(count);
    take(values.data(), count * sizeof(T));
  }
  /// Returns the next values in place, aligned by reserve order of the writer.
  template <class T>
  requires std::is_trivially_copyable_v<T>
  [[nodiscard]] std::span<const T> view() {
    const std::size_t count = taken_count(sizeof(T));
    const std::byte* const at = left_.data();
    if (reinterpret_cast<std::uintptr_t>(at) % alignof(T) != 0) refuse();
    left_ = left_.subspan(count * sizeof(T));
    return {reinterpret_cast<const T*>(at), count};
  }
  void get(std::string& text) {
    std::vector<char> letters;
    get(letters);
    text.assign(letters.begin(), letters.end());
  }

 private:
  [[noreturn]] static void refuse();
  [[nodiscard]] std::size_t taken_count(std::size_t size) {
    std::uint64_t count = 0;
    take(&count, sizeof count);
    if (count > left_.size() / size) refuse();
    return count;
  }
  void take(void* to, std::size_t count) {
    if (count > left_.size()) refuse();
    if (count > 0) std::memcpy(to, left_.data(), count);
    left_ = left_.subspan(count);
  }
  std::span<const std::byte> left_;
};

// Ranks within one process, one thread each.

/// Runs `work` concurrently for each of `count` ranks, rank 0 on the calling thread, and returns when all have
/// finished. When one throws, the others fail at their next call, and this function rethrows the first
/// exception.
void run_rank_threads(std::size_t count, const std::function<void(Ranks&)>& work);

}  // namespace simuli
