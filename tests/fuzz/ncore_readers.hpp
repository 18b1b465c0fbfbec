#pragma once
// What is read of NCore, without files and folders in between: those take a hundred times as long.
#include <filesystem>

namespace simuli::test {

/// The last block of an .itar, then its index before compression, which no change of the compressed bytes
/// would get past.
void read_itar_parts(const std::filesystem::path& file);
/// An array's .zarray and its one chunk, with kBetweenParts between them.
void read_zarr_parts(const std::filesystem::path& file);
/// A sequence: one JSON object of all keys that hold JSON, then the bytes of a sweep's arrays, with
/// kBetweenParts between them. All that an import makes of them, but for writing it.
void read_ncore_parts(const std::filesystem::path& file);

}  // namespace simuli::test
