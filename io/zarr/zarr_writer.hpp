#pragma once
// Writer of Zarr v2 stores as NCore requires: consolidated metadata in .zmetadata.cbor.xz, arrays compressed by
// Blosc. For io/ncore and tests.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/base/json_reader.hpp"

namespace simuli {

class ZarrWriter {
 public:
  /// Receives entries: a key and its bytes.
  using Sink = std::function<void(const std::string& key, const std::string& bytes)>;
  explicit ZarrWriter(Sink sink);

  /// Adds a group and its missing parents.
  void group(const std::string& path, const Json& attributes = nullptr);
  /// Adds row-major little-endian items of a NumPy type such as "<f4"; empty `chunk`: a single chunk.
  void array(const std::string& path,
             const std::vector<std::size_t>& shape,
             const std::string& type,
             std::string bytes,
             const Json& attributes = nullptr,
             const std::vector<std::size_t>& chunk = {});
  /// Adds a file's bytes as one uncompressed item.
  void file(const std::string& path, const std::string& bytes, const Json& attributes = nullptr);
  template <class T>
  void array(const std::string& path,
             const std::vector<std::size_t>& shape,
             const std::string& type,
             std::span<const T> values,
             const Json& attributes = nullptr,
             const std::vector<std::size_t>& chunk = {}) {
    array(path,
          shape,
          type,
          std::string(reinterpret_cast<const char*>(values.data()), values.size_bytes()),
          attributes,
          chunk);
  }
  /// Writes the consolidated metadata; the last call.
  void finish();

 private:
  void put_json(const std::string& key, const Json& value);
  void put_header(const std::string& path,
                  const std::vector<std::size_t>& shape,
                  const std::vector<std::size_t>& chunk,
                  const std::string& type,
                  const Json& compressor,
                  const Json& attributes);

  Sink sink_;
  Json metadata_ = Json::object();
};

/// Fills a new store atomically: a folder, or one file for names ending in .itar. Throws Error{kInput} for an
/// existing folder of that name, and if nothing can be written.
void write_zarr(const std::filesystem::path& path, const std::function<void(ZarrWriter&)>& fill);

}  // namespace simuli
