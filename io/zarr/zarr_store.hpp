#pragma once
// Zarr v2 stores with the features that recordings use: groups with attributes and chunked arrays, in a folder
// or in one indexed tar file (.itar). For io/zarr, io/ncore and tests.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io/base/json_reader.hpp"

namespace simuli {

/// Whether this build has libblosc and liblzma, which these stores need.
[[nodiscard]] bool has_zarr();

/// Bytes by key ("cameras/front/.zattrs"), read on request.
class ZarrStore {
 public:
  virtual ~ZarrStore() = default;
  [[nodiscard]] virtual bool has(const std::string& key) const = 0;
  /// Throws Error{kInput} naming file and key for a missing entry and for more bytes than kLargestEntry.
  [[nodiscard]] virtual std::string read(const std::string& key) const = 0;
  /// Returns the names of the groups and arrays directly below a group ("" is the root).
  [[nodiscard]] virtual std::vector<std::string> children(const std::string& group) const = 0;
  /// Returns the store's name for messages.
  [[nodiscard]] virtual std::string name() const = 0;
};

/// Limit of entries and arrays, because a few bytes can claim any size.
inline constexpr std::uint64_t kLargestEntry = std::uint64_t{1} << 28U;

/// Opens a folder with a .zgroup, or an .itar. Throws Error{kInput} for other and damaged files, and in builds
/// without has_zarr().
[[nodiscard]] std::unique_ptr<const ZarrStore> open_zarr(const std::filesystem::path& path);
/// Opens an .itar only.
[[nodiscard]] std::unique_ptr<const ZarrStore> open_itar(const std::filesystem::path& file);

/// Returns "a/b" for a group and a name in it; the root is "".
[[nodiscard]] std::string zarr_key(const std::string& group, const std::string& name);

[[nodiscard]] bool is_group(const ZarrStore& store, const std::string& path);
[[nodiscard]] bool is_array(const ZarrStore& store, const std::string& path);

/// Returns the attributes of a group or an array: an object, possibly empty. Throws Error{kInput} for invalid
/// JSON.
[[nodiscard]] Json zarr_attributes(const ZarrStore& store, const std::string& path);

/// An array in memory: row-major, little-endian.
struct ZarrArray {
  std::vector<std::size_t> shape;  // empty: a scalar
  std::string type;                // "<f4", "<u8", "|u1", "|S1234" ...
  std::string bytes;

  [[nodiscard]] std::size_t count() const;
};

/// Throws Error{kInput} naming file and key for an unsupported type, order, filter or compressor, for chunks
/// that are missing, damaged or of a wrong size, and for arrays above kLargestEntry.
[[nodiscard]] ZarrArray read_zarr_array(const ZarrStore& store, const std::string& path);

}  // namespace simuli
