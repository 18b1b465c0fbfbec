#pragma once
// Common Data Representation, version 1, little endian, the encoding of ROS 2 messages. After a header of 4
// bytes, numbers are aligned to their size; strings are their length including a terminating zero, their bytes
// and the zero; sequences their length and elements; fixed arrays their elements.
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "host/core/base/error.hpp"

namespace simuli::ros2 {

class CdrWriter {
 public:
  template <class T>
  CdrWriter& number(T value) {
    static_assert(std::is_arithmetic_v<T>);
    while ((bytes_.size() - kHead) % sizeof(T) != 0) bytes_.push_back('\0');
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  CdrWriter& text(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size() + 1));
    bytes_.append(value).push_back('\0');
    return *this;
  }
  /// Appends a sequence of bytes.
  CdrWriter& bytes(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size()));
    bytes_.append(value);
    return *this;
  }
  /// Appends the length of a sequence; its elements follow.
  CdrWriter& length(std::size_t count) { return number(static_cast<std::uint32_t>(count)); }
  template <class Numbers>
  CdrWriter& all(const Numbers& values) {
    for (const auto value : values) number(value);
    return *this;
  }
  [[nodiscard]] const std::string& message() const { return bytes_; }

 private:
  static constexpr std::size_t kHead = 4;
  std::string bytes_{"\0\1\0\0", kHead};
};

/// Reads this encoding; `where` names message and file. Throws Error{kInput} for invalid data; lengths are
/// checked against the remaining bytes.
class CdrReader {
 public:
  CdrReader(std::string_view message, std::string file, std::string where)
      : file_(std::move(file)), where_(std::move(where)) {
    if (message.starts_with("\x28\xb5\x2f\xfd"))
      refuse("message", "compressed by itself with Zstandard", "a plain one: ros2 bag convert");
    if (message.size() < kHead || message[0] != '\0' || message[1] != '\1')
      refuse("first bytes", "others", "0 1: CDR, version 1, little endian");
    bytes_ = message.substr(kHead);
  }

  template <class T>
  T number(const char* field) {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    at_ += (sizeof(T) - at_ % sizeof(T)) % sizeof(T);
    T value{};
    std::memcpy(&value, take(sizeof(T), field).data(), sizeof(T));
    return value;
  }
  std::string text(const char* field) {
    const auto count = number<std::uint32_t>(field);
    if (count == 0) return {};  // some writers omit the zero of empty strings
    const std::string_view raw = take(count, field);
    if (raw.back() != '\0') refuse(field, "no zero behind it", "one");
    return std::string(raw.substr(0, raw.size() - 1));
  }
  std::string_view bytes(const char* field) {
    const auto count = number<std::uint32_t>(field);
    return take(count, field);
  }
  /// Reads the length of a sequence whose elements have at least `least_bytes` bytes each.
  std::size_t length(const char* field, std::size_t least_bytes) {
    const std::size_t count = number<std::uint32_t>(field);
    if (count > (bytes_.size() - at_) / least_bytes)
      refuse(field, std::to_string(count) + " elements", "no more than there are bytes for");
    return count;
  }
  template <class Numbers>
  void all(Numbers& values, const char* field) {
    for (auto& value : values) value = number<std::remove_reference_t<decltype(value)>>(field);
  }
  [[noreturn]] void refuse(const std::string& field,
                           const std::string& found,
                           const std::string& allowed) const {
    throw_input_error(file_, where_ + ": " + field, found, allowed);
  }

 private:
  std::string_view take(std::size_t count, const char* field) {
    if (at_ > bytes_.size() || count > bytes_.size() - at_)
      refuse(field, "the end of the message", "a whole one");
    const std::string_view taken = bytes_.substr(at_, count);
    at_ += count;
    return taken;
  }
  static constexpr std::size_t kHead = 4;
  std::string file_, where_;
  std::string_view bytes_;
  std::size_t at_ = 0;
};

}  // namespace simuli::ros2
