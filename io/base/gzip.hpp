#pragma once
// Compressed bytes. Included by io/*.cpp alone.
#include <cstddef>
#include <string>

namespace simuli {

[[nodiscard]] bool is_gzip(const std::string& bytes);
/// The contents, of gzip or zlib; Error{kInput} naming `file` when they are damaged, cut short or more than
/// most_bytes.
[[nodiscard]] std::string gunzip(const std::string& bytes, const std::string& file, std::size_t most_bytes);
[[nodiscard]] std::string gzip(const std::string& bytes);

/// Whether unzstd() works in this build.
[[nodiscard]] bool has_zstd();
/// One Zstandard frame of exactly `size` bytes; Error{kInput} naming `file` otherwise.
[[nodiscard]] std::string unzstd(const char* bytes,
                                 std::size_t count,
                                 std::size_t size,
                                 const std::string& file);

}  // namespace simuli
