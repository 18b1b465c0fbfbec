#pragma once
// The index of an .itar. For io/zarr/*.cpp and tests.
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace simuli {

inline constexpr std::uint64_t kTarBlock = 512;

struct ItarEntry {
  std::uint64_t offset = 0, size = 0;  // bytes, of the data in the file
};
struct ItarTrailer {
  std::uint64_t offset = 0, size = 0;  // bytes, of the index
};

/// Of the last block of a file, which begins at `at`. Error{kInput} naming `file` when it is no such block,
/// or the index doesn't end before it.
[[nodiscard]] ItarTrailer read_itar_trailer(std::string_view block,
                                            std::uint64_t at,
                                            const std::string& file);
/// Of the CBOR text; entries end before `end`. Error{kInput} naming `file` for damage, for entries that lie
/// elsewhere or are larger than kLargestEntry, and names that stand twice.
[[nodiscard]] std::map<std::string, ItarEntry> read_itar_index(std::string_view cbor,
                                                               std::uint64_t end,
                                                               const std::string& file);

/// The two the other way: the CBOR text, and the last block.
[[nodiscard]] std::string itar_index(const std::map<std::string, ItarEntry>& entries);
[[nodiscard]] std::string itar_trailer(const ItarTrailer& trailer);

}  // namespace simuli
