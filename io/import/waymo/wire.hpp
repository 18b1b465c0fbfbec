#pragma once
// Messages in Protocol Buffers' wire format, read field by field: importers need a dozen values of a large
// public schema. For io/*.cpp.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace simuli {

struct WireField {
  std::uint32_t number = 0;
  std::uint64_t value = 0;  // of a varint, or the bits of a fixed32 or fixed64
  std::string_view bytes;   // of a string, message or packed array; also of fixed values
  bool is_bytes = false;
};

/// Returns all fields of a message in order. Throws Error{kInput} "FILE: WHAT: ..." if they do not end at its
/// end.
[[nodiscard]] std::vector<WireField> wire_fields(std::string_view message,
                                                 const std::string& file,
                                                 const char* what);

/// Appends the doubles of a field, packed or single.
void append_doubles(const WireField& field, std::vector<double>& to);
[[nodiscard]] double wire_double(const WireField& field);
/// Returns a packed array of floats.
[[nodiscard]] std::vector<float> wire_floats(std::string_view bytes);

}  // namespace simuli
