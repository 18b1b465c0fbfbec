#pragma once
// The index of an .itar, for io/zarr/*.cpp and tests.
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace simuli {

inline constexpr std::uint64_t kTarBlock = 512;

struct ItarEntry {
  std::uint64_t offset = 0, size = 0;  // bytes; of the data in the file
};
struct ItarTrailer {
  std::uint64_t offset = 0, size = 0;  // bytes, of the index
};

/// Parses the last block of a file, which begins at `at`. Throws Error{kInput} naming `file` for an invalid
/// block, and for an index that does not end before it.
[[nodiscard]] ItarTrailer read_itar_trailer(std::string_view block,
                                            std::uint64_t at,
                                            const std::string& file);
/// Parses the CBOR text; entries end before `end`. Throws Error{kInput} naming `file` for damaged data, entries
/// out of range or larger than kLargestEntry, and repeated names.
[[nodiscard]] std::map<std::string, ItarEntry> read_itar_index(std::string_view cbor,
                                                               std::uint64_t end,
                                                               const std::string& file);

/// Writes both: the CBOR text, and the last block.
[[nodiscard]] std::string itar_index(const std::map<std::string, ItarEntry>& entries);
[[nodiscard]] std::string itar_trailer(const ItarTrailer& trailer);

}  // namespace simuli
