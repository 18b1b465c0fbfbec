#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/core/base/error.hpp"
#include "io/base/gzip.hpp"
#include "io/zarr/zarr_codec.hpp"
#include "io/zarr/zarr_store.hpp"

namespace simuli {
namespace {

constexpr std::size_t kMostDimensions = 4;

/// Returns the bytes of an item: numbers of one byte or little-endian, and byte strings.
std::size_t item_bytes(const std::string& type, const std::string& file) {
  std::size_t size = 0;
  const bool is_sound =
      type.size() >= 3 &&
      std::from_chars(type.data() + 2, type.data() + type.size(), size).ptr == type.data() + type.size();
  const bool is_number =
      std::string_view("fiub").find(type.size() > 1 ? type[1] : ' ') != std::string_view::npos;
  const bool is_known =
      is_sound && size >= 1 &&
      ((type[1] == 'S' && size <= kLargestEntry) ||
       (is_number && (size == 1 || (type[0] == '<' && (size == 2 || size == 4 || size == 8)))));
  if (!is_known) {
    throw_input_error(
        file, "dtype", '"' + type.substr(0, 60) + '"', "little-endian numbers or bytes, as <f4, |S9");
  }
  return size;
}

std::vector<std::size_t> sizes_of(JsonObject& header, const std::string& key, std::size_t least) {
  std::vector<std::size_t> out;
  for (const Json& size : header.get(key)) {
    const bool is_size = size.is_number_unsigned() && size.get<std::uint64_t>() >= least &&
                         size.get<std::uint64_t>() <= kLargestEntry;
    if (!is_size || out.size() == kMostDimensions)
      throw_input_error(header.file(), key, "other values", fmt::format("at most {} sizes", kMostDimensions));
    out.push_back(size.get<std::size_t>());
  }
  return out;
}

/// Returns the product of sizes and item bytes. Throws Error{kInput} above kLargestEntry.
std::size_t bytes_of(const std::vector<std::size_t>& sizes, std::size_t item, const std::string& file) {
  std::size_t bytes = item;
  for (const std::size_t size : sizes) {
    if (size == 0) return 0;
    if (bytes > kLargestEntry / size)
      throw_input_error(file, "shape", fmt::format("{}", fmt::join(sizes, " x ")), "at most 256 MiB");
    bytes *= size;
  }
  return bytes;
}

struct Header {
  std::vector<std::size_t> shape, chunks;
  std::string type, compressor, separator;
};

Header read_header(const ZarrStore& store, const std::string& path, const std::string& file) {
  return read_json_text(store.read(zarr_key(path, ".zarray")), file, [&](JsonObject& h) {
    h.ignore_other_keys();  // fill_value is ignored: every chunk must exist
    Header out;
    (void)h.integer("zarr_format", 2, 2);
    out.shape = sizes_of(h, "shape", 0);
    out.chunks = sizes_of(h, "chunks", 1);
    if (out.shape.size() != out.chunks.size())
      throw_input_error(file, "chunks", "other dimensions than shape", "the same");
    out.type = h.text("dtype");
    if (out.shape.size() > 1 && h.text("order") != "C") throw_input_error(file, "order", "\"F\"", "\"C\"");
    if (h.has("filters") && !h.get("filters").is_null()) throw_input_error(file, "filters", "some", "none");
    if (!h.get("compressor").is_null()) {
      out.compressor = h.object("compressor", [](JsonObject& c) {
        c.ignore_other_keys();
        return c.text("id");
      });
    }
    out.separator = h.has("dimension_separator") ? h.text("dimension_separator") : ".";
    return out;
  });
}

std::string decoded(const std::string& bytes,
                    const std::string& compressor,
                    std::size_t size,
                    const std::string& file) {
  if (compressor == "blosc") return unblosc(bytes, size, file);
  if (compressor == "zstd") return unzstd(bytes.data(), bytes.size(), size, file);
  if (!compressor.empty() && compressor != "zlib" && compressor != "gzip") {
    throw_input_error(
        file, "compressor", '"' + compressor.substr(0, 60) + '"', "blosc, zstd, zlib, gzip or none");
  }
  std::string out = compressor.empty() ? bytes : gunzip(bytes, file, size);
  if (out.size() != size)
    throw_input_error(file, "size", fmt::format("{} bytes", out.size()), fmt::format("{} bytes", size));
  return out;
}

/// Row-major shapes with four dimensions; missing leading ones are 1.
using Sizes = std::array<std::size_t, kMostDimensions>;
Sizes padded(const std::vector<std::size_t>& sizes) {
  Sizes out;
  out.fill(1);
  std::copy(sizes.rbegin(), sizes.rend(), out.rbegin());
  return out;
}

/// Copies a chunk that begins at `first` into the array; parts beyond the array are padding.
void place(const std::string& chunk,
           const Sizes& chunks,
           const Sizes& first,
           const Sizes& shape,
           std::size_t item,
           std::string& to) {
  Sizes n;
  for (std::size_t d = 0; d < n.size(); ++d) n[d] = std::min(chunks[d], shape[d] - first[d]);
  for (std::size_t i = 0; i < n[0]; ++i) {
    for (std::size_t j = 0; j < n[1]; ++j) {
      for (std::size_t k = 0; k < n[2]; ++k) {
        const std::size_t from = ((i * chunks[1] + j) * chunks[2] + k) * chunks[3];
        const std::size_t at =
            (((first[0] + i) * shape[1] + first[1] + j) * shape[2] + first[2] + k) * shape[3] + first[3];
        std::memcpy(to.data() + at * item, chunk.data() + from * item, n[3] * item);
      }
    }
  }
}

}  // namespace

std::size_t ZarrArray::count() const {
  std::size_t out = 1;
  for (const std::size_t size : shape) out *= size;
  return out;
}

ZarrArray read_zarr_array(const ZarrStore& store, const std::string& path) {
  const std::string file = store.name() + ": " + path;
  const Header header = read_header(store, path, file);
  const std::size_t item = item_bytes(header.type, file), chunk_size = bytes_of(header.chunks, item, file);
  ZarrArray out{header.shape, header.type, {}};
  const std::size_t size = bytes_of(header.shape, item, file);
  if (size == 0) return out;
  const Sizes shape = padded(header.shape), chunks = padded(header.chunks);
  Sizes first{};
  const std::size_t skipped = kMostDimensions - header.shape.size();
  for (bool more = true; more;) {
    std::string key = header.shape.empty() ? "0" : "";
    for (std::size_t d = skipped; d < kMostDimensions; ++d) {
      if (d > skipped) key += header.separator;
      key += std::to_string(first[d] / chunks[d]);
    }
    const std::string whole_key = zarr_key(path, key);
    if (!store.has(whole_key)) throw_input_error(file, "chunk " + key, "none", "all of them");
    const std::string chunk =
        decoded(store.read(whole_key), header.compressor, chunk_size, store.name() + ": " + whole_key);
    // allocated after a chunk has matched the header, because a few bytes can claim any size
    out.bytes.resize(size);
    place(chunk, chunks, first, shape, item, out.bytes);
    more = false;
    for (std::size_t d = kMostDimensions; d-- > 0 && !more;) {
      first[d] += chunks[d];
      more = first[d] < shape[d];
      if (!more) first[d] = 0;
    }
  }
  return out;
}

}  // namespace simuli
