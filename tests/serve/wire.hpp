#pragma once
// Messages made by hand: field numbers and wire types as the protocol's facts tell them, and nothing of the
// generated code.
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace simuli::test {

class Wire {
 public:
  Wire& varint(std::uint32_t field, std::uint64_t value) {
    tag(field, 0);
    raw_varint(value);
    return *this;
  }
  Wire& fixed64(std::uint32_t field, std::uint64_t value) { return raw(field, 1, &value, sizeof(value)); }
  Wire& real64(std::uint32_t field, double value) { return raw(field, 1, &value, sizeof(value)); }
  Wire& real32(std::uint32_t field, float value) { return raw(field, 5, &value, sizeof(value)); }
  Wire& text(std::uint32_t field, const std::string& value) {
    tag(field, 2);
    raw_varint(value.size());
    bytes_ += value;
    return *this;
  }
  Wire& message(std::uint32_t field, const Wire& value) { return text(field, value.bytes_); }
  template <class T>
  Wire& packed(std::uint32_t field, const std::vector<T>& values) {
    std::string all(values.size() * sizeof(T), '\0');
    std::memcpy(all.data(), values.data(), all.size());
    return text(field, all);
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  static_assert(std::endian::native == std::endian::little);
  void raw_varint(std::uint64_t value) {
    for (; value >= 128; value >>= 7U) bytes_ += static_cast<char>((value & 127U) | 128U);
    bytes_ += static_cast<char>(value);
  }
  void tag(std::uint32_t field, std::uint32_t type) { raw_varint(field << 3U | type); }
  Wire& raw(std::uint32_t field, std::uint32_t type, const void* value, std::size_t size) {
    tag(field, type);
    bytes_.append(static_cast<const char*>(value), size);
    return *this;
  }
  std::string bytes_;
};

}  // namespace simuli::test
