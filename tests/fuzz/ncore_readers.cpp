#include "tests/fuzz/ncore_readers.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/ncore/ncore_sequence.hpp"
#include "io/log/log_json.hpp"
#include "io/ncore/models.hpp"
#include "io/zarr/itar_index.hpp"
#include "tests/fuzz/mutate/mutate.hpp"

namespace simuli::test {
namespace {

using namespace ncore;

class StoreInMemory : public ZarrStore {
 public:
  explicit StoreInMemory(std::map<std::string, std::string> entries) : entries_(std::move(entries)) {}
  [[nodiscard]] bool has(const std::string& key) const override { return entries_.contains(key); }
  [[nodiscard]] std::string read(const std::string& key) const override {
    const auto found = entries_.find(key);
    if (found == entries_.end()) throw_input_error("memory", key, "none", "an entry");
    return found->second;
  }
  [[nodiscard]] std::vector<std::string> children(const std::string& group) const override {
    std::set<std::string> names;
    const std::string prefix = group.empty() ? "" : group + '/';
    for (auto at = entries_.lower_bound(prefix); at != entries_.end() && at->first.starts_with(prefix); ++at)
      names.insert(at->first.substr(prefix.size(), at->first.find('/', prefix.size()) - prefix.size()));
    std::vector<std::string> out;
    for (const std::string& name : names) {
      if (is_group(*this, prefix + name) || is_array(*this, prefix + name)) out.push_back(name);
    }
    return out;
  }
  [[nodiscard]] std::string name() const override { return "memory"; }

 private:
  std::map<std::string, std::string> entries_;
};

std::vector<std::string> parts_of(const std::filesystem::path& file) {
  const std::string all = read_file(file);
  const std::string_view between = kBetweenParts;
  std::vector<std::string> out;
  for (std::size_t at = 0;;) {
    const std::size_t end = all.find(between, at);
    out.push_back(all.substr(at, end - at));
    if (end == std::string::npos) return out;
    at = end + between.size();
  }
}

/// An object's values by their keys, as they are written: the reader parses each, and to parse all of them
/// here first took longer than the reader.
std::map<std::string, std::string> values_of(std::string_view text, const std::filesystem::path& file) {
  constexpr std::size_t kNone = std::string_view::npos;
  const auto refuse = [&] { throw_input_error(file.string(), "root", "no object", "an object"); };
  const auto behind_string = [text](std::size_t at) {
    for (++at; at < text.size() && text[at] != '"'; ++at) at += text[at] == '\\' ? 1 : 0;
    return std::min(at + 1, text.size());
  };
  std::map<std::string, std::string> out;
  std::size_t at = text.find_first_not_of(" \n\r\t");
  if (at == kNone || text[at] != '{') refuse();
  do {
    const std::size_t key = text.find('"', at);
    if (key == kNone) break;
    const std::size_t end = behind_string(key);
    at = text.find(':', end);
    if (at == kNone) refuse();
    const std::size_t value = ++at;
    for (int depth = 0; at < text.size(); ++at) {
      const char here = text[at];
      if (depth == 0 && (here == ',' || here == '}')) break;
      if (here == '{' || here == '[') ++depth;
      if (here == '}' || here == ']') --depth;
      if (here == '"') at = behind_string(at) - 1;
    }
    out[std::string(text.substr(key + 1, end - key - 2))] = text.substr(value, at - value);
  } while (at < text.size() && text[at] == ',');
  return out;
}

constexpr std::size_t kMostLenses = 10'000;

void read_sensors_of(const Sequence& sequence) {
  for (const auto& [name, place] : sequence.instances("cameras")) {
    const auto at = sequence.find("intrinsics", "cameras/" + name);
    if (!at) continue;
    // Looking for a lens's folds takes longer than all else: once for each.
    static std::set<std::string> known;
    const Json attributes = at->attributes();
    JsonObject intrinsics(at->file(), "", attributes);
    if (known.size() > kMostLenses) known.clear();
    if (known.insert(attributes.dump(-1, ' ', false, Json::error_handler_t::replace)).second)
      (void)intrinsics_of(camera_from_intrinsics(intrinsics, name));
    (void)Sequence::frames(place);
  }
  for (const auto& [name, place] : sequence.instances("lidars")) {
    const auto at = sequence.find("intrinsics", "lidars/" + name);
    if (!at) continue;
    const Json attributes = at->attributes();
    JsonObject intrinsics(at->file(), "", attributes);
    const RayGrid grid(lidar_from_intrinsics(intrinsics, name));
    for (const FrameTime& time : Sequence::frames(place)) {
      const ZarrGroup frame = place / ("frames/" + std::to_string(time.end_us));
      std::size_t left_out = 0;
      Sweep sweep = grid.sweep(read_rays(frame, left_out), time, frame.file(), left_out);
      grid.restore(read_exact(frame), sweep);
    }
  }
}

}  // namespace

void read_itar_parts(const std::filesystem::path& file) {
  const std::string bytes = read_file(file);
  constexpr std::size_t kTrailer = 20;
  constexpr std::uint64_t kEnd = 100'000;
  const ItarTrailer trailer =
      read_itar_trailer(std::string_view(bytes).substr(0, kTrailer), kEnd, file.string());
  (void)read_itar_index(std::string_view(bytes).substr(kTrailer), trailer.offset, file.string());
}

void read_zarr_parts(const std::filesystem::path& file) {
  const std::vector<std::string> parts = parts_of(file);
  const std::string chunk = parts.size() > 1 ? parts[1] : "";
  const StoreInMemory store({{"a/.zarray", parts[0]}, {"a/0", chunk}, {"a/0.0", chunk}, {"a/1.0", chunk}});
  (void)read_zarr_array(store, "a");
}

void read_ncore_parts(const std::filesystem::path& file) {
  constexpr std::array<const char*, 8> kArrays{"ray_bundle/direction/0.0",
                                               "ray_bundle/timestamp_us/0",
                                               "ray_bundle/model_element/0.0",
                                               "ray_bundle_returns/distance_m/0.0",
                                               "ray_bundle_returns/intensity/0.0",
                                               "ray_bundle_returns_valid_mask_packed/0",
                                               "generic_data/simuli_ray/0",
                                               "generic_data/simuli_values/0.0"};
  const std::vector<std::string> parts = parts_of(file);
  std::map<std::string, std::string> entries = values_of(parts[0], file);
  for (std::size_t i = 0; i < kArrays.size() && i + 1 < parts.size(); ++i)
    entries[std::string("lidars/top/frames/1100000/") + kArrays[i]] = parts[i + 1];
  const Sequence sequence(std::make_unique<const StoreInMemory>(std::move(entries)));
  (void)sequence.in_order("lidars");
  read_sensors_of(sequence);
  const Sequence::Path path = sequence.path("world", "rig");
  std::size_t unposed = 0;
  LabelReport labels;
  (void)actors_of(sequence, path, "world", "rig", unposed, labels);
}

}  // namespace simuli::test
