#pragma once
// Compressed bytes of Zarr stores. For io/zarr/*.cpp alone.
#include <cstddef>
#include <string>

namespace simuli {

/// Blosc: LZ4 behind a bitwise shuffle of items.
[[nodiscard]] std::string blosc(const std::string& bytes, std::size_t item_bytes);
/// Of exactly `size` bytes; Error{kInput} naming `file` otherwise.
[[nodiscard]] std::string unblosc(const std::string& bytes, std::size_t size, const std::string& file);

[[nodiscard]] std::string xz(const std::string& bytes);
/// Error{kInput} naming `file` when it is damaged, cut short or more than most_bytes.
[[nodiscard]] std::string unxz(const std::string& bytes, const std::string& file, std::size_t most_bytes);

}  // namespace simuli
