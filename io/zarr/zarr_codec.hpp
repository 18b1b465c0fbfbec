#pragma once
// Compression of Zarr stores, for io/zarr/*.cpp.
#include <cstddef>
#include <string>

namespace simuli {

/// Compresses with Blosc: bit shuffle of items, then LZ4.
[[nodiscard]] std::string blosc(const std::string& bytes, std::size_t item_bytes);
/// Decompresses exactly `size` bytes. Throws Error{kInput} naming `file` otherwise.
[[nodiscard]] std::string unblosc(const std::string& bytes, std::size_t size, const std::string& file);

[[nodiscard]] std::string xz(const std::string& bytes);
/// Throws Error{kInput} naming `file` for damaged or truncated data and for more than most_bytes.
[[nodiscard]] std::string unxz(const std::string& bytes, const std::string& file, std::size_t most_bytes);

}  // namespace simuli
