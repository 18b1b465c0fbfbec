#pragma once
// Conversion between a log's times (seconds from its start) and NCore's (whole microseconds since 1970), for
// io/ncore and io/import/ncore.
#include <cmath>
#include <cstdint>

namespace simuli::ncore {

inline constexpr std::int64_t kNanoseconds = 1000;  // per microsecond
inline constexpr std::int64_t kSecond_us = 1'000'000;

class Clock {
 public:
  Clock() = default;
  /// `shift_us` is added to all times, because NCore has no times before 1970.
  Clock(std::int64_t start_ns, std::int64_t shift_us) : start_ns_(start_ns), shift_us_(shift_us) {}

  [[nodiscard]] std::int64_t ns(double time_s) const {
    return start_ns_ + static_cast<std::int64_t>(std::llround(time_s * 1e9));
  }
  /// Rounds to the nearest microsecond.
  [[nodiscard]] std::uint64_t us(double time_s) const {
    const std::int64_t time_ns = ns(time_s);
    const std::int64_t half = time_ns >= 0 ? kNanoseconds / 2 : -kNanoseconds / 2;
    return static_cast<std::uint64_t>((time_ns + half) / kNanoseconds + shift_us_);
  }
  [[nodiscard]] double seconds(std::uint64_t time_us) const {
    return seconds_of_ns((static_cast<std::int64_t>(time_us) - shift_us_) * kNanoseconds);
  }
  [[nodiscard]] double seconds_of_ns(std::int64_t time_ns) const {
    return static_cast<double>(time_ns - start_ns_) * 1e-9;
  }
  /// Whether NCore represents the time exactly.
  [[nodiscard]] bool is_whole(double time_s) const { return ns(time_s) % kNanoseconds == 0; }

  [[nodiscard]] std::int64_t start_ns() const { return start_ns_; }
  [[nodiscard]] std::int64_t shift_us() const { return shift_us_; }

 private:
  std::int64_t start_ns_ = 0, shift_us_ = 0;
};

}  // namespace simuli::ncore
