#include <bit>
#include <cstring>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/import/waymo/waymo_frame.hpp"

namespace simuli {

static_assert(std::endian::native == std::endian::little, "the wire format is little endian");

std::vector<WireField> wire_fields(std::string_view message, const std::string& file, const char* what) {
  const auto refuse = [&](const std::string& found) {
    throw_input_error(file, what, found, "a whole message");
  };
  std::size_t at = 0;
  const auto varint = [&] {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      if (at == message.size()) refuse("its end within a number");
      const auto byte = static_cast<std::uint8_t>(message[at++]);
      value |= static_cast<std::uint64_t>(byte & 127U) << shift;
      if (byte < 128) return value;
    }
    refuse("a number of more than 64 bits");
    return value;
  };
  const auto take = [&](std::uint64_t count) {
    if (count > message.size() - at)
      refuse(fmt::format("a field of {} bytes in {}", count, message.size() - at));
    const std::string_view bytes = message.substr(at, count);
    at += count;
    return bytes;
  };
  std::vector<WireField> fields;
  while (at < message.size()) {
    const std::uint64_t tag = varint();
    WireField field;
    field.number = static_cast<std::uint32_t>(tag >> 3U);
    switch (tag & 7U) {
      case 0:
        field.value = varint();
        break;
      case 1:
        field.bytes = take(8);
        break;
      case 2:
        field.bytes = take(varint());
        field.is_bytes = true;
        break;
      case 5:
        field.bytes = take(4);
        break;
      default:
        refuse(fmt::format("wire type {}", tag & 7U));
    }
    if (!field.is_bytes && !field.bytes.empty()) {
      std::memcpy(&field.value, field.bytes.data(), field.bytes.size());
    }
    fields.push_back(field);
  }
  return fields;
}

void append_doubles(const WireField& field, std::vector<double>& to) {
  for (std::size_t at = 0; at + 8 <= field.bytes.size(); at += 8) {
    double value = 0.0;
    std::memcpy(&value, field.bytes.data() + at, 8);
    to.push_back(value);
  }
}

double wire_double(const WireField& field) { return std::bit_cast<double>(field.value); }

std::vector<float> wire_floats(std::string_view bytes) {
  std::vector<float> out(bytes.size() / 4);
  if (!out.empty()) std::memcpy(out.data(), bytes.data(), 4 * out.size());
  return out;
}

}  // namespace simuli
