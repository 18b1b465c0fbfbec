#pragma once
// Zarr v2 stores as NCore has them: consolidated metadata in .zmetadata.cbor.xz, arrays by Blosc. For
// io/ncore and tests.
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
  /// Where entries go: a key and its bytes.
  using Sink = std::function<void(const std::string& key, const std::string& bytes)>;
  explicit ZarrWriter(Sink sink);

  /// A group, and those above it that are not there yet.
  void group(const std::string& path, const Json& attributes = nullptr);
  /// Row-major little-endian items of a numpy type such as "<f4"; empty `chunk`: all in one.
  void array(const std::string& path,
             const std::vector<std::size_t>& shape,
             const std::string& type,
             std::string bytes,
             const Json& attributes = nullptr,
             const std::vector<std::size_t>& chunk = {});
  /// A file's own bytes as one item, stored as they are.
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
  /// Writes the consolidated metadata, behind everything else.
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

/// Fills a new store, complete or not at all: a folder, or one file when the name ends in .itar.
/// Error{kInput} when there is something of that name and it is a folder, or nothing can be written.
void write_zarr(const std::filesystem::path& path, const std::function<void(ZarrWriter&)>& fill);

}  // namespace simuli
