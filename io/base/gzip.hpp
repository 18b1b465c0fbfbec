#pragma once
// Compression of byte strings, for io/*.cpp.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace simuli {

[[nodiscard]] bool is_gzip(const std::string& bytes);
/// Decompresses gzip or zlib data. Throws Error{kInput} naming `file` for damaged or truncated data and for
/// more than most_bytes.
[[nodiscard]] std::string gunzip(const std::string& bytes, const std::string& file, std::size_t most_bytes);
/// Decompresses the first `count` bytes, or fewer at the end of the data. Errors as in gunzip().
[[nodiscard]] std::string gunzip_start(const std::string& bytes, std::size_t count, const std::string& file);
[[nodiscard]] std::string gzip(const std::string& bytes);

/// Whether zstd() and unzstd() are supported by this build.
[[nodiscard]] bool has_zstd();
/// Returns one Zstandard frame. Throws Error{kUsage} unless has_zstd().
[[nodiscard]] std::string zstd(const std::string& bytes);
/// Decompresses a Zstandard frame of exactly `size` bytes. Throws Error{kInput} naming `file` otherwise.
[[nodiscard]] std::string unzstd(const char* bytes,
                                 std::size_t count,
                                 std::size_t size,
                                 const std::string& file);

/// Decompresses LZ4 frames of exactly `size` bytes. Throws Error{kInput} naming `file` otherwise, and in a
/// build without liblz4.
[[nodiscard]] std::string unlz4(const char* bytes,
                                std::size_t count,
                                std::size_t size,
                                const std::string& file);

/// Returns the CRC-32 (as in gzip) of the bytes with the CRC `before` followed by `bytes`.
[[nodiscard]] std::uint32_t crc_32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace simuli
