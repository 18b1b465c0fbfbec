#pragma once
// Zarr v2, the parts that recordings use: groups with attributes, arrays in chunks, in a folder or in one
// indexed tar file (.itar). For io/zarr, io/ncore and tests.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io/base/json_reader.hpp"

namespace simuli {

/// Whether this build reads and writes such stores: it has libblosc and liblzma.
[[nodiscard]] bool has_zarr();

/// Bytes by key ("cameras/front/.zattrs"), read when asked for.
class ZarrStore {
 public:
  virtual ~ZarrStore() = default;
  [[nodiscard]] virtual bool has(const std::string& key) const = 0;
  /// Error{kInput} naming file and key when there is none, and for more bytes than kLargestEntry.
  [[nodiscard]] virtual std::string read(const std::string& key) const = 0;
  /// What stands right below a group ("" is the root) and is a group or an array itself, by name.
  [[nodiscard]] virtual std::vector<std::string> children(const std::string& group) const = 0;
  /// For messages.
  [[nodiscard]] virtual std::string name() const = 0;
};

/// An entry of more bytes is refused, and so is an array: a few bytes may say to become as many.
inline constexpr std::uint64_t kLargestEntry = std::uint64_t{1} << 28U;

/// A folder with a .zgroup, or an .itar. Error{kInput} when it is neither, is damaged, and in builds without.
[[nodiscard]] std::unique_ptr<const ZarrStore> open_zarr(const std::filesystem::path& path);
/// The .itar alone.
[[nodiscard]] std::unique_ptr<const ZarrStore> open_itar(const std::filesystem::path& file);

/// "a/b" of a group and a name below it; the root is "".
[[nodiscard]] std::string zarr_key(const std::string& group, const std::string& name);

[[nodiscard]] bool is_group(const ZarrStore& store, const std::string& path);
[[nodiscard]] bool is_array(const ZarrStore& store, const std::string& path);

/// Attributes of a group or an array: an object, empty where there are none. Error{kInput} for bad JSON.
[[nodiscard]] Json zarr_attributes(const ZarrStore& store, const std::string& path);

/// An array as it is in memory: row-major, little-endian.
struct ZarrArray {
  std::vector<std::size_t> shape;  // empty: a scalar
  std::string type;                // "<f4", "<u8", "|u1", "|S1234" ...
  std::string bytes;

  [[nodiscard]] std::size_t count() const;
};

/// Error{kInput} naming file and key for a type, order, filter or compressor that is not read, for chunks
/// that are missing, damaged or of another size, and for arrays above kLargestEntry.
[[nodiscard]] ZarrArray read_zarr_array(const ZarrStore& store, const std::string& path);

}  // namespace simuli
