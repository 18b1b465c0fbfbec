#include "io/import/ncore/ncore_sequence.hpp"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/export/drive_parts.hpp"
#include "io/ncore/names.hpp"

namespace simuli::ncore {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kLatest_us = 4'000'000'000'000'000;  // 2096

/// Parses a time stamp that 64-bit nanoseconds can represent.
std::uint64_t stamp_of(const Json& value, const std::string& file, const std::string& field) {
  if (value.is_number_unsigned() && value.get<std::uint64_t>() <= static_cast<std::uint64_t>(kLatest_us))
    return value.get<std::uint64_t>();
  throw_input_error(
      file, field, value.is_number() ? "another number" : "no number", "microseconds since 1970");
}

std::int64_t integer_or(const Json& object, const char* key, std::int64_t otherwise) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_integer()) return otherwise;
  if (found->is_number_unsigned() && found->get<std::uint64_t>() > std::uint64_t{1} << 62U) return otherwise;
  const auto value = found->get<std::int64_t>();
  return std::abs(value) <= kLatest_us * kNanoseconds ? value : otherwise;
}

}  // namespace

Json ours_of(const Json& attributes) {
  const auto meta = attributes.find("generic_meta_data");
  if (meta == attributes.end() || !meta->is_object()) return Json::object();
  const auto found = meta->find(kOurs);
  return found != meta->end() && found->is_object() ? *found : Json::object();
}

std::optional<Eigen::Quaterniond> rotation_from(const Json& wxyz) {
  if (!wxyz.is_array() || wxyz.size() != 4) return std::nullopt;
  for (const Json& value : wxyz) {
    if (!value.is_number()) return std::nullopt;
  }
  const Eigen::Quaterniond out(
      wxyz[0].get<double>(), wxyz[1].get<double>(), wxyz[2].get<double>(), wxyz[3].get<double>());
  if (!(std::abs(out.norm() - 1.0) < 1e-9)) return std::nullopt;
  return out;
}

Sequence::Sequence(const fs::path& path) : file_(path.string()) {
  std::error_code ignored;
  if (!is_there(path)) throw_input_error(file_, "file", "none", "a sequence of NCore");
  if (ending_of(path) == ".json") {
    read_json_text(read_file(path), file_, [&](JsonObject& root) {
      root.ignore_other_keys();
      (void)root.objects("component_stores", [&](JsonObject& store) {
        store.ignore_other_keys();
        add(open_zarr(below(path.parent_path(), store.text("path"), file_, store.field("path"))));
        return 0;
      });
    });
  } else if (fs::is_directory(path, ignored) && !is_there(path / ".zgroup")) {
    std::vector<fs::path> parts;
    for (const auto& entry : fs::directory_iterator(path, ignored)) {
      const std::string name = entry.path().filename().string();
      const bool is_store = name.ends_with(".zarr") || name.ends_with(".zarr.itar");
      if (is_store && name.find(".ncore4") != std::string::npos) parts.push_back(entry.path());
    }
    std::sort(parts.begin(), parts.end());
    for (const fs::path& part : parts) add(open_zarr(part));
  } else {
    add(open_zarr(path));
  }
  if (stores_.empty()) throw_input_error(file_, "stores", "none", "NAME.ncore4*.zarr or .zarr.itar");
  add_poses();
}

Sequence::Sequence(std::unique_ptr<const ZarrStore> store) : file_(store->name()) {
  add(std::move(store));
  add_poses();
}

void Sequence::add_poses() {
  for (const auto& [name, place] : instances("poses")) {
    const ZarrGroup still = place / "static_poses", moving = place / "dynamic_poses";
    poses_.add_static(still.attributes(), still.file());
    poses_.add_dynamic(moving.attributes(), moving.file());
  }
}

void Sequence::add(std::unique_ptr<const ZarrStore> opened) {
  stores_.push_back(std::move(opened));
  const ZarrStore& store = *stores_.back();
  const Json attributes = zarr_attributes(store, "");
  JsonObject root(store.name() + ": .zattrs", "", attributes);
  if (root.text("version") != kVersion) {
    throw_input_error(root.file(), "version", '"' + root.text("version").substr(0, 60) + '"', "\"v4\"");
  }
  const std::string id = root.text("sequence_id");
  if (stores_.size() == 1) {
    id_ = id;
    ours_ = ours_of(attributes);
    const Json& interval = root.get("sequence_timestamp_interval_us");
    const auto start = interval.find("start");
    if (!interval.is_object() || start == interval.end())
      throw_input_error(root.file(), "sequence_timestamp_interval_us", "no start", "start and stop");
    const std::uint64_t first_us = stamp_of(*start, root.file(), "sequence_timestamp_interval_us.start");
    clock_ = Clock(integer_or(ours_, "start_ns", static_cast<std::int64_t>(first_us) * kNanoseconds),
                   integer_or(ours_, "shift_us", 0));
  } else if (id != id_) {
    throw_input_error(root.file(), "sequence_id", '"' + id.substr(0, 60) + '"', "that of the other stores");
  }
  add_components(store);
}

void Sequence::add_components(const ZarrStore& store) {
  for (const std::string& kind : store.children("")) {
    for (const std::string& name : store.children(kind)) {
      const ZarrGroup place{&store, zarr_key(kind, name)};
      const Json attributes = place.attributes();
      const auto version = attributes.find("component_version");
      if (version == attributes.end() || *version != kComponentVersion) {
        throw_input_error(
            place.file(), "component_version", "another", std::string("\"") + kComponentVersion + '"');
      }
      if (!components_[kind].emplace(name, place).second)
        throw_input_error(place.file(), "name", "one that another store has", "each once");
    }
  }
}

const std::map<std::string, ZarrGroup>& Sequence::instances(const std::string& kind) const {
  static const std::map<std::string, ZarrGroup> none;
  const auto found = components_.find(kind);
  return found == components_.end() ? none : found->second;
}

std::optional<ZarrGroup> Sequence::find(const std::string& kind, const std::string& group) const {
  for (const auto& [name, place] : instances(kind)) {
    if ((place / group).is_there()) return place / group;
  }
  return std::nullopt;
}

std::vector<FrameTime> Sequence::frames(const ZarrGroup& sensor) {
  const ZarrGroup frames = sensor / "frames";
  const Json attributes = frames.attributes();
  const auto times = attributes.find("frames_timestamps_us");
  if (times == attributes.end() || !times->is_array())
    throw_input_error(frames.file(), "frames_timestamps_us", "none", "[[start, end], ...]");
  std::vector<FrameTime> out;
  for (const Json& time : *times) {
    const std::string field = fmt::format("frames_timestamps_us[{}]", out.size());
    if (!time.is_array() || time.size() != 2)
      throw_input_error(frames.file(), field, "no pair", "[start, end]");
    const FrameTime frame{stamp_of(time[0], frames.file(), field), stamp_of(time[1], frames.file(), field)};
    if (frame.end_us < frame.start_us || (!out.empty() && frame.end_us <= out.back().end_us))
      throw_input_error(frames.file(), field, "an end before its start or the last end", "time's order");
    out.push_back(frame);
  }
  return out;
}

std::vector<std::string> Sequence::in_order(const std::string& kind) const {
  std::vector<std::string> out;
  const auto known = ours_.find(kind);
  const std::map<std::string, ZarrGroup>& all = instances(kind);
  const auto add = [&](const std::string& name) {
    if (all.contains(name) && std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
  };
  if (known != ours_.end() && known->is_array()) {
    for (const Json& name : *known) {
      if (name.is_string()) add(name.get<std::string>());
    }
  }
  for (const auto& [name, place] : all) add(name);
  return out;
}

std::vector<double> Sequence::times_of(const std::vector<std::uint64_t>& stamps, const Json& ours) const {
  std::vector<double> out;
  for (const std::uint64_t stamp : stamps) out.push_back(clock_.seconds(stamp));
  const auto found = ours.find("time_ns");
  if (found == ours.end() || !found->is_array() || found->size() != stamps.size()) return out;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const Json& time = (*found)[i];
    if (!time.is_number_integer()) continue;
    const auto time_ns = time.get<std::int64_t>();
    if (time_ns < -kLatest_us * kNanoseconds || time_ns > kLatest_us * kNanoseconds) continue;
    const double exact_s = clock_.seconds_of_ns(time_ns);
    if (clock_.us(exact_s) == stamps[i]) out[i] = exact_s;
  }
  return out;
}

Sequence::Path Sequence::path(const std::string& world, const std::string& rig) const {
  std::vector<StampedPose> stamped = poses_.path(world, rig);
  if (stamped.empty()) {
    throw_input_error(
        file_,
        "poses",
        poses_.pairs(),
        fmt::format("poses of {} in {}, or other frames by --rig-frame and --world-frame", rig, world));
  }
  Json ours = Json::object();
  for (const auto& [name, place] : instances("poses")) ours = ours_of(place.attributes());
  std::vector<std::uint64_t> stamps;
  for (const StampedPose& pose : stamped) stamps.push_back(pose.stamp_us);
  const std::vector<double> times_s = times_of(stamps, ours);
  const auto rotations = ours.find("rotations_wxyz");
  std::vector<TimedPose> poses;
  for (std::size_t i = 0; i < stamped.size(); ++i) {
    Pose pose = stamped[i].pose;
    if (rotations != ours.end() && rotations->is_array() && rotations->size() == stamped.size()) {
      const auto exact = rotation_from((*rotations)[i]);
      // Returns the stored rotation: the nearest rotation of the matrix, except for rounding.
      constexpr double kRounding = 1e-12;
      if (exact && (exact->coeffs() - pose.rotation.coeffs()).norm() < kRounding) pose.rotation = *exact;
      if (exact && (exact->coeffs() + pose.rotation.coeffs()).norm() < kRounding) pose.rotation = *exact;
    }
    poses.push_back({times_s[i], pose});
  }
  Path out;
  out.first_s = poses.front().time_s;
  out.last_s = poses.back().time_s;
  const auto is_false = [&](const char* key) {
    const auto found = ours.find(key);
    return found != ours.end() && found->is_boolean() && !found->get<bool>();
  };
  if (is_false("begins_with_path") && poses.size() > 1) poses.erase(poses.begin());
  if (is_false("ends_with_path") && poses.size() > 1) poses.pop_back();
  out.trajectory = with_context("reading " + file_, [&] { return Trajectory(std::move(poses)); });
  return out;
}

}  // namespace simuli::ncore
