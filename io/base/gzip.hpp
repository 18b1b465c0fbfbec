#pragma once
// Compressed bytes. Included by io/*.cpp alone.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace simuli {

[[nodiscard]] bool is_gzip(const std::string& bytes);
/// The contents, of gzip or zlib; Error{kInput} naming `file` when they are damaged, cut short or more than
/// most_bytes.
[[nodiscard]] std::string gunzip(const std::string& bytes, const std::string& file, std::size_t most_bytes);
/// The first `count` bytes of it, fewer where there are no more, and nothing further unpacked. Errors alike.
[[nodiscard]] std::string gunzip_start(const std::string& bytes, std::size_t count, const std::string& file);
[[nodiscard]] std::string gzip(const std::string& bytes);

/// Whether zstd() and unzstd() work in this build.
[[nodiscard]] bool has_zstd();
/// One Zstandard frame; Error{kUsage} where has_zstd() says no.
[[nodiscard]] std::string zstd(const std::string& bytes);
/// One Zstandard frame of exactly `size` bytes; Error{kInput} naming `file` otherwise.
[[nodiscard]] std::string unzstd(const char* bytes,
                                 std::size_t count,
                                 std::size_t size,
                                 const std::string& file);

/// LZ4 frames of exactly `size` bytes; Error{kInput} naming `file` otherwise, and in a build without liblz4.
[[nodiscard]] std::string unlz4(const char* bytes,
                                std::size_t count,
                                std::size_t size,
                                const std::string& file);

/// CRC-32 as in gzip, of `bytes` behind those that `before` is the one of.
[[nodiscard]] std::uint32_t crc_32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace simuli
