#include "io/zarr/itar_index.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/bytes.hpp"
#include "io/base/json_reader.hpp"
#include "io/zarr/zarr_store.hpp"

namespace simuli {
namespace {

constexpr std::string_view kMagic = "itar";
constexpr std::uint64_t kCborXz = 1;
constexpr std::size_t kHeaderBytes = 20;

std::uint64_t little_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8U | static_cast<unsigned char>(bytes[i]);
  return value;
}

/// Parses the subset of CBOR that the index uses: a map of text to arrays of text or numbers without nesting.
/// nlohmann's from_cbor() is recursive: 200 kB of nested arrays, a few hundred bytes in XZ, would overflow the
/// stack.
class Cbor {
 public:
  enum Major : unsigned { kNumber = 0, kText = 3, kArray = 4, kMap = 5 };

  Cbor(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  [[nodiscard]] std::uint64_t head(Major wanted) {
    const unsigned first = static_cast<unsigned char>(take(1)[0]);
    const unsigned low = first & 31U;
    if (first >> 5U != wanted || low > 27U) refuse();
    if (low < 24U) return low;
    std::uint64_t value = 0;
    for (const char byte : take(std::size_t{1} << (low - 24U)))
      value = value << 8U | static_cast<unsigned char>(byte);
    return value;
  }
  [[nodiscard]] std::string text() { return std::string(take(head(kText))); }
  /// Returns the number of elements of an array; each has at least a byte.
  [[nodiscard]] std::size_t count() {
    const std::uint64_t n = head(kArray);
    if (n > bytes_.size()) refuse();
    return static_cast<std::size_t>(n);
  }
  void finish() const {
    if (!bytes_.empty()) refuse();
  }
  [[noreturn]] void refuse() const {
    throw_input_error(file_, "index", "damaged", "items, offset_datas and sizes in CBOR");
  }

 private:
  std::string_view take(std::uint64_t n) {
    if (n > bytes_.size()) refuse();
    const std::string_view out = bytes_.substr(0, n);
    bytes_.remove_prefix(n);
    return out;
  }

  std::string_view bytes_;
  const std::string& file_;
};

}  // namespace

ItarTrailer read_itar_trailer(std::string_view block, std::uint64_t at, const std::string& file) {
  if (block.size() < kHeaderBytes || !block.starts_with(kMagic)) {
    throw_input_error(file, "last block", "no index", "an indexed tar file (.itar), whole");
  }
  const std::uint64_t kind = little_endian(block.substr(4, 4));
  if (kind != kCborXz) throw_input_error(file, "index", fmt::format("kind {}", kind), "kind 1");
  const ItarTrailer out{little_endian(block.substr(8, 8)), little_endian(block.substr(16, 4))};
  if (out.offset > at || out.size > at - out.offset || out.size > kLargestEntry) {
    throw_input_error(file,
                      "index",
                      fmt::format("{} bytes at {}", out.size, out.offset),
                      fmt::format("before the last block at {}", at));
  }
  return out;
}

std::map<std::string, ItarEntry> read_itar_index(std::string_view cbor,
                                                 std::uint64_t end,
                                                 const std::string& file) {
  Cbor in(cbor, file);
  std::vector<std::string> items;
  std::vector<std::uint64_t> offsets, sizes;
  for (std::uint64_t left = in.head(Cbor::kMap); left > 0; --left) {
    const std::string key = in.text();
    std::size_t count = in.count();
    if (key == "items") {
      for (; count > 0; --count) items.push_back(in.text());
    } else if (key == "offset_datas" || key == "sizes") {
      std::vector<std::uint64_t>& to = key == "sizes" ? sizes : offsets;
      for (; count > 0; --count) to.push_back(in.head(Cbor::kNumber));
    } else {
      in.refuse();
    }
  }
  in.finish();
  if (offsets.size() != items.size() || sizes.size() != items.size()) in.refuse();
  std::map<std::string, ItarEntry> out;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (offsets[i] > end || sizes[i] > end - offsets[i] || sizes[i] > kLargestEntry) {
      throw_input_error(file,
                        "index: " + items[i].substr(0, 200),
                        fmt::format("{} bytes at {}", sizes[i], offsets[i]),
                        fmt::format("at most {} bytes, before the index at {}", kLargestEntry, end));
    }
    if (!out.emplace(std::move(items[i]), ItarEntry{offsets[i], sizes[i]}).second)
      throw_input_error(file, "index", "a repeated name", "each once");
  }
  return out;
}

std::string itar_index(const std::map<std::string, ItarEntry>& entries) {
  using Entry = std::pair<const std::string, ItarEntry>;
  std::vector<const Entry*> by_place;
  for (const Entry& entry : entries) by_place.push_back(&entry);
  std::sort(by_place.begin(), by_place.end(), [](const Entry* a, const Entry* b) {
    return a->second.offset < b->second.offset;
  });
  Json items = Json::array(), offsets = Json::array(), sizes = Json::array();
  for (const Entry* entry : by_place) {
    items.push_back(entry->first);
    offsets.push_back(entry->second.offset);
    sizes.push_back(entry->second.size);
  }
  const std::vector<std::uint8_t> cbor =
      Json::to_cbor(Json{{"items", items}, {"offset_datas", offsets}, {"sizes", sizes}});
  return {cbor.begin(), cbor.end()};
}

std::string itar_trailer(const ItarTrailer& trailer) {
  std::string out(kMagic);
  append_little_endian(out, kCborXz, 4);
  append_little_endian(out, trailer.offset, 8);
  append_little_endian(out, trailer.size, 4);
  out.resize(kTarBlock, '\0');
  return out;
}

}  // namespace simuli
