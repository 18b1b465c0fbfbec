#include "io/zarr/zarr_writer.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/zarr/itar_index.hpp"
#include "io/zarr/zarr_codec.hpp"
#include "io/zarr/zarr_store.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

/// Writes a field's octal digits followed by a NUL.
void put_octal(std::string& block, std::size_t at, std::size_t width, std::uint64_t value) {
  const std::string digits = fmt::format("{:0{}o}", value, width - 1);
  block.replace(at, digits.size(), digits);
}

constexpr std::size_t kTarName =
    100;  // bytes of a header's name field; longer names are in a preceding block

/// Returns a header block of a tar file.
std::string tar_header(const std::string& name, std::uint64_t size, char kind) {
  constexpr std::size_t kChecksum = 148;
  std::string block(kTarBlock, '\0');
  block.replace(0, std::min(name.size(), kTarName), name.substr(0, kTarName));
  put_octal(block, 100, 8, 0644);
  put_octal(block, 108, 8, 0);
  put_octal(block, 116, 8, 0);
  put_octal(block, 124, 12, size);
  put_octal(block, 136, 12, 0);  // modification time 0, so that the same content has the same bits
  block.replace(kChecksum, 8, 8, ' ');
  block[156] = kind;
  block.replace(257, 8, std::string("ustar\00000", 8));
  unsigned sum = 0;
  for (const char byte : block) sum += static_cast<unsigned char>(byte);
  put_octal(block, kChecksum, 7, sum);
  return block;
}

std::string filling(std::uint64_t size) {
  return std::string((kTarBlock - size % kTarBlock) % kTarBlock, '\0');
}

class ItarFile {
 public:
  explicit ItarFile(const fs::path& file) : file_(file), out_(file, std::ios::binary) {}

  void add(const std::string& key, const std::string& bytes) {
    if (key.size() > kTarName) {  // GNU tar's extension, which Python supports
      put(tar_header("././@LongLink", key.size() + 1, 'L'));
      put(key + std::string(kTarBlock - key.size() % kTarBlock, '\0'));
    }
    put(tar_header(key, bytes.size(), '0'));
    if (!entries_.emplace(key, ItarEntry{at_, bytes.size()}).second)
      throw Error(ErrorKind::kInternal, "tar: " + key + " twice");
    put(bytes);
    put(filling(bytes.size()));
  }
  void finish() {
    constexpr std::uint64_t kRecord = 20 * kTarBlock;  // tar files end with a complete record
    put(std::string(2 * kTarBlock, '\0'));
    put(std::string((kRecord - at_ % kRecord) % kRecord, '\0'));
    const std::string index = xz(itar_index(entries_));
    const ItarTrailer trailer{at_, index.size()};
    put(index);
    put(filling(index.size()));
    put(itar_trailer(trailer));
    out_.close();
    need_good();
  }

 private:
  void put(const std::string& bytes) {
    out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    at_ += bytes.size();
    need_good();
  }
  void need_good() const {
    if (!out_) throw_input_error(file_.string(), "content", "a write error", "a path that can be written");
  }

  fs::path file_;
  std::ofstream out_;
  std::uint64_t at_ = 0;
  std::map<std::string, ItarEntry> entries_;
};

}  // namespace

ZarrWriter::ZarrWriter(Sink sink) : sink_(std::move(sink)) {}

void ZarrWriter::put_json(const std::string& key, const Json& value) {
  sink_(key, value.dump(1, ' ', true));
  metadata_[key] = value;
}

void ZarrWriter::group(const std::string& path, const Json& attributes) {
  if (!metadata_.contains(zarr_key(path, ".zgroup"))) {
    if (!path.empty()) {
      const std::size_t parent = path.rfind('/');
      group(parent == std::string::npos ? "" : path.substr(0, parent));
    }
    put_json(zarr_key(path, ".zgroup"), {{"zarr_format", 2}});
  }
  if (!attributes.is_null()) put_json(zarr_key(path, ".zattrs"), attributes);
}

void ZarrWriter::put_header(const std::string& path,
                            const std::vector<std::size_t>& shape,
                            const std::vector<std::size_t>& chunk,
                            const std::string& type,
                            const Json& compressor,
                            const Json& attributes) {
  const std::size_t parent = path.rfind('/');
  group(parent == std::string::npos ? "" : path.substr(0, parent));
  const bool is_text = type[1] == 'S';
  put_json(zarr_key(path, ".zarray"),
           {{"chunks", chunk},
            {"compressor", compressor},
            {"dtype", type},
            {"fill_value",
             is_text          ? Json("")
             : type[1] == 'f' ? Json(0.0)
                              : Json(0)},
            {"filters", nullptr},
            {"order", "C"},
            {"shape", shape},
            {"zarr_format", 2}});
  if (!attributes.is_null()) put_json(zarr_key(path, ".zattrs"), attributes);
}

void ZarrWriter::array(const std::string& path,
                       const std::vector<std::size_t>& shape,
                       const std::string& type,
                       std::string bytes,
                       const Json& attributes,
                       const std::vector<std::size_t>& chunk) {
  std::vector<std::size_t> chunks = chunk.empty() ? shape : chunk;
  for (std::size_t& size : chunks) size = std::max<std::size_t>(size, 1);
  put_header(path,
             shape,
             chunks,
             type,
             {{"blocksize", 0}, {"clevel", 5}, {"cname", "lz4"}, {"id", "blosc"}, {"shuffle", 2}},
             attributes);
  if (bytes.empty()) return;
  const std::size_t item = std::stoul(type.substr(2));
  // Chunks are whole rows: all rows in one chunk, or one chunk per row.
  const std::size_t count = shape.empty() ? 1 : (shape[0] + chunks[0] - 1) / chunks[0],
                    size = bytes.size() / count;
  for (std::size_t i = 0; i < count; ++i) {
    std::string key = std::to_string(i);
    for (std::size_t d = 1; d < shape.size(); ++d) key += ".0";
    sink_(zarr_key(path, key), blosc(count == 1 ? bytes : bytes.substr(i * size, size), item));
  }
}

void ZarrWriter::file(const std::string& path, const std::string& bytes, const Json& attributes) {
  put_header(path, {}, {}, fmt::format("|S{}", bytes.size()), nullptr, attributes);
  sink_(zarr_key(path, "0"), bytes);
}

void ZarrWriter::finish() {
  const std::vector<std::uint8_t> cbor =
      Json::to_cbor(Json{{"zarr_consolidated_format", 1}, {"metadata", metadata_}});
  sink_(".zmetadata.cbor.xz", xz({cbor.begin(), cbor.end()}));
}

void write_zarr(const fs::path& path, const std::function<void(ZarrWriter&)>& fill) {
  const auto filled = [&](const ZarrWriter::Sink& sink) {
    ZarrWriter writer(sink);
    fill(writer);
    writer.finish();
  };
  if (path.extension() == ".itar") {
    write_atomically(path, [&](const fs::path& temporary) {
      ItarFile file(temporary);
      filled([&](const std::string& key, const std::string& bytes) { file.add(key, bytes); });
      file.finish();
    });
    return;
  }
  write_folder_atomically(path, [&](const fs::path& temporary) {
    filled([&](const std::string& key, const std::string& bytes) {
      const fs::path file = temporary / key;
      fs::create_directories(file.parent_path());
      std::ofstream out(file, std::ios::binary);
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      out.close();
      if (!out) throw_input_error(file.string(), "content", "a write error", "a path that can be written");
    });
  });
}

}  // namespace simuli
