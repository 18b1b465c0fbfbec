#pragma once
// Those that train one scene together: processes of MPI, or threads with a device each.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/base/error.hpp"

namespace simuli {

/// One of them, as it sees the others. All ranks make the same calls in the same order.
class Ranks {
 public:
  using Bytes = std::vector<std::byte>;

  Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  virtual ~Ranks() = default;

  [[nodiscard]] virtual std::size_t rank() const = 0;  // from 0
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// What each rank gives, by rank. Nothing is added or changed on the way. An exception when another rank
  /// has ended.
  [[nodiscard]] virtual std::vector<Bytes> all_gather(std::span<const std::byte> own) = 0;

  /// Whether it holds for any rank.
  [[nodiscard]] bool any(bool own);
  /// What rank 0 has.
  [[nodiscard]] bool first(bool own);
  /// Returns when all ranks have come here.
  void wait_for_all();
  [[nodiscard]] bool is_first() const { return rank() == 0; }
};

/// A training by itself.
[[nodiscard]] Ranks& one_rank();

/// What all ranks must have alike: "device" and its name, ...
struct RankField {
  std::string name;
  std::string value;
};
/// Ranks that can't give the same bits. Thrown in all of them, with the same text.
class RanksDiffer : public Error {
 public:
  explicit RanksDiffer(const std::string& what) : Error(ErrorKind::kDevice, what) {}
};
/// RanksDiffer reading "rank 2: driver: found FOUND, expected EXPECTED of rank 0", of the first rank that has
/// a field otherwise than rank 0.
void need_same(Ranks& ranks, const std::vector<RankField>& fields);

/// Values without pointers, one behind the other, as ranks send them.
class RankWriter {
 public:
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const std::vector<T>& values) {
    const std::uint64_t count = values.size();
    append(&count, sizeof count);
    append(values.data(), values.size() * sizeof(T));
  }
  void put(const std::string& text) { put(std::vector<char>(text.begin(), text.end())); }
  [[nodiscard]] Ranks::Bytes take() { return std::move(bytes_); }

 private:
  void append(const void* from, std::size_t count) {
    const auto* const first = static_cast<const std::byte*>(from);
    bytes_.insert(bytes_.end(), first, first + count);
  }
  Ranks::Bytes bytes_;
};

/// Reads what a RankWriter has written, in its order. Error{kInternal} for other bytes.
class RankReader {
 public:
  explicit RankReader(std::span<const std::byte> bytes) : left_(bytes) {}
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get(std::vector<T>& values) {
    std::uint64_t count = 0;
    take(&count, sizeof count);
    if (count > left_.size() / sizeof(T)) refuse();
    values.resize(count);
    take(values.data(), count * sizeof(T));
  }
  void get(std::string& text) {
    std::vector<char> letters;
    get(letters);
    text.assign(letters.begin(), letters.end());
  }

 private:
  [[noreturn]] static void refuse();
  void take(void* to, std::size_t count) {
    if (count > left_.size()) refuse();
    if (count > 0) std::memcpy(to, left_.data(), count);
    left_ = left_.subspan(count);
  }
  std::span<const std::byte> left_;
};

}  // namespace simuli
