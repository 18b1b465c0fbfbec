#pragma once
// Messages in the wire format of Protocol Buffers, read field by field: what an importer needs of a large
// public schema is a dozen numbers. Included by io/*.cpp alone.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace simuli {

struct WireField {
  std::uint32_t number = 0;
  std::uint64_t value = 0;  // of a varint, or the bits of a fixed32 or fixed64
  std::string_view bytes;   // of a string, message or packed array; fixed values too
  bool is_bytes = false;
};

/// All fields of a message in their order. Error{kInput} "FILE: WHAT: ..." when they don't end where it ends.
[[nodiscard]] std::vector<WireField> wire_fields(std::string_view message,
                                                 const std::string& file,
                                                 const char* what);

/// Appends the doubles of a field, packed or one.
void append_doubles(const WireField& field, std::vector<double>& to);
[[nodiscard]] double wire_double(const WireField& field);
/// A packed array of floats.
[[nodiscard]] std::vector<float> wire_floats(std::string_view bytes);

}  // namespace simuli
