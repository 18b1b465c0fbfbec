#include "io/ncore/ncore_export.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/export/drive_parts.hpp"
#include "io/log/log_json.hpp"
#include "io/ncore/clock.hpp"
#include "io/ncore/models.hpp"
#include "io/ncore/names.hpp"
#include "io/ncore/poses.hpp"
#include "io/ncore/rays.hpp"
#include "io/picture/image.hpp"
#include "io/zarr/zarr_store.hpp"
#include "io/zarr/zarr_writer.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace ncore;

Json wxyz(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

template <class Values>
auto view(const Values& values) {
  return std::span<const typename Values::value_type>(values);
}

/// Returns a mask as PNG; PNG files unchanged.
std::string png_of(const fs::path& file) {
  std::string bytes = read_file(file, kLargestEntry);
  if (bytes.starts_with("\x89PNG")) return bytes;
  Image mask = read_image(file);
  // includes values that 8 bits would round to 0
  for (float& value : mask.data) value = value != 0.0F ? 1.0F : 0.0F;
  return encode_image(mask, ImageCode::kPng);
}

class Exporter {
 public:
  Exporter(const Log& log, ZarrWriter& writer, NcoreExport& report)
      : log_(log), out_(writer), report_(report) {
    find_clock();
  }

  void write(const std::function<void(std::size_t, std::size_t)>& progress) {
    auto step = [&, done = std::size_t{0}]() mutable {
      if (progress) progress(++done, log_.images.size() + log_.sweeps.size());
    };
    add_poses();
    add_root();
    out_.group(component("intrinsics"), attributes("intrinsics", kOnly));
    for (const char* const kind : {"cameras", "lidars"}) out_.group(zarr_key(component("intrinsics"), kind));
    for (const LogCamera& camera : log_.cameras) add_camera(camera, step);
    for (const LogLidar& lidar : log_.lidars) add_lidar(lidar, step);
    add_masks();
    if (!log_.actors.empty()) add_boxes();
  }

 private:
  static Json attributes(const std::string& kind, const std::string& name, Json more = Json::object()) {
    return {{"component_name", kind},
            {"component_instance_name", name},
            {"component_version", kComponentVersion},
            {"generic_meta_data", more.empty() ? std::move(more) : Json{{kOurs, std::move(more)}}}};
  }

  /// Finds the first and last time, in seconds of the log and as written.
  void find_clock() {
    double first_s = log_.world_from_rig.start_s(), last_s = log_.world_from_rig.end_s();
    const auto reach = [&](const auto& frame) {
      first_s = std::min(first_s, frame.time_start_s);
      last_s = std::max(last_s, frame.time_end_s);
    };
    for (const ImageFrame& frame : log_.images) reach(frame);
    for (const SweepFrame& frame : log_.sweeps) reach(frame);
    frames_first_s_ = first_s;
    frames_last_s_ = last_s;
    for (const Actor& actor : log_.actors) {
      first_s = std::min(first_s, actor.track.front().time_s);
      last_s = std::max(last_s, actor.track.back().time_s);
    }
    clock_ = Clock(log_.start_ns, 0);
    const std::int64_t first_ns = clock_.ns(first_s), second_ns = kSecond_us * kNanoseconds;
    // Whole seconds, so that other clocks keep the same subsecond part.
    const std::int64_t seconds = first_ns < 0 ? (-first_ns + second_ns - 1) / second_ns : 0;
    clock_ = Clock(log_.start_ns, seconds * kSecond_us);
    first_us_ = clock_.us(first_s);
    last_us_ = clock_.us(last_s);
  }

  void add_root() {
    Json ours{{"start_ns", log_.start_ns}, {"cameras", Json::array()}, {"lidars", Json::array()}};
    if (clock_.shift_us() != 0) ours["shift_us"] = clock_.shift_us();
    for (const LogCamera& camera : log_.cameras) ours["cameras"].push_back(camera.model.name);
    for (const LogLidar& lidar : log_.lidars) ours["lidars"].push_back(name_of(lidar.model));
    out_.group("",
               {{"sequence_id", log_.name},
                {"sequence_timestamp_interval_us", {{"start", first_us_}, {"stop", last_us_ + 1}}},
                {"generic_meta_data", {{kOurs, std::move(ours)}}},
                {"version", kVersion},
                {"component_group_name", ""}});
  }

  void add_poses() {
    const Trajectory& path = log_.world_from_rig;
    Json poses = Json::array(), stamps = Json::array(), rotations = Json::array(), times = Json::array();
    bool are_whole = true;
    const auto add = [&](double time_s, const Pose& pose) {
      poses.push_back(rows_of(pose.matrix()));
      stamps.push_back(clock_.us(time_s));
      rotations.push_back(wxyz(pose.rotation));
      times.push_back(clock_.ns(time_s));
      are_whole = are_whole && clock_.is_whole(time_s);
    };
    // NCore's readers do not extrapolate a trajectory.
    const bool is_late = clock_.us(frames_first_s_) < clock_.us(path.start_s());
    bool is_early = clock_.us(frames_last_s_) > clock_.us(path.end_s());
    if (is_late) add(frames_first_s_, path.at(frames_first_s_));
    for (const TimedPose& timed : path.poses()) add(timed.time_s, timed.pose);
    if (is_early) add(frames_last_s_, path.at(frames_last_s_));
    if (poses.size() == 1) {  // NCore needs at least two poses
      constexpr double kMicrosecond_s = 1e-6;
      add(path.end_s() + kMicrosecond_s, path.poses().back().pose);
      last_us_ = std::max(last_us_, clock_.us(path.end_s()) + 1);
      is_early = true;
    }
    Json ours{{"rotations_wxyz", std::move(rotations)}};
    if (!are_whole) ours["time_ns"] = std::move(times);
    if (is_late) ours["begins_with_path"] = false;
    if (is_early) ours["ends_with_path"] = false;
    Json mounts = Json::object();
    const auto mount = [&](const std::string& name, const Pose& rig_from_sensor) {
      mounts[key_of(name, kRig)] = {{"pose", rows_of(rig_from_sensor.matrix())}, {"dtype", "float64"}};
    };
    for (const LogCamera& camera : log_.cameras) mount(camera.model.name, camera.rig_from_camera);
    for (const LogLidar& lidar : log_.lidars) mount(name_of(lidar.model), lidar.rig_from_lidar);
    const std::string at = component("poses");
    out_.group(at, attributes("poses", kOnly, std::move(ours)));
    out_.group(zarr_key(at, "static_poses"), mounts);
    out_.group(
        zarr_key(at, "dynamic_poses"),
        Json{{key_of(kRig, kWorld),
              {{"poses", std::move(poses)}, {"timestamps_us", std::move(stamps)}, {"dtype", "float64"}}}});
  }

  /// Writes the frames of a sensor by their end times: `add(frame, group, time)` writes the content of each.
  template <class Frame, class Is, class Add>
  void add_frames(const std::string& at, const std::vector<Frame>& frames, const Is& is_own, const Add& add) {
    std::map<std::uint64_t, std::uint64_t> start_by_end;
    for (const Frame& frame : frames) {
      if (!is_own(frame)) continue;
      const FrameTime time{clock_.us(frame.time_start_s), clock_.us(frame.time_end_s)};
      if (!start_by_end.emplace(time.end_us, time.start_us).second) {
        throw_input_error((log_.folder / "log.json").string(),
                          frame.file,
                          fmt::format("an end at {} us, when another frame of the sensor ends", time.end_us),
                          "one frame a microsecond");
      }
      const std::string group = fmt::format("{}/frames/{}", at, time.end_us);
      Json ours = Json::object();
      if (!clock_.is_whole(frame.time_start_s) || !clock_.is_whole(frame.time_end_s))
        ours = {{kOurs, {{"time_ns", {clock_.ns(frame.time_start_s), clock_.ns(frame.time_end_s)}}}}};
      out_.group(zarr_key(group, "generic_data"), ours);
      add(frame, group, time);
    }
    Json times = Json::array();
    for (const auto& [end_us, start_us] : start_by_end) times.push_back({start_us, end_us});
    out_.group(zarr_key(at, "frames"), Json{{"frames_timestamps_us", std::move(times)}});
  }

  template <class Step>
  void add_camera(const LogCamera& camera, Step& step) {
    const std::string& name = camera.model.name;
    const Json intrinsics = intrinsics_of(camera.model);
    if (intrinsics.is_null()) {
      report_.left_out.push_back(fmt::format(
          "camera {}, whose lens ({}) has no name in NCore", name, to_string(camera.model.lens.kind())));
      return;
    }
    out_.group(zarr_key(component("intrinsics"), "cameras/" + name), intrinsics);
    const std::string at = "cameras/" + name;
    out_.group(at, attributes("cameras", name, Json{{"sensor", to_json(camera)}}));
    const auto is_own = [&](const ImageFrame& frame) { return frame.camera == name; };
    add_frames(
        at, log_.images, is_own, [&](const ImageFrame& frame, const std::string& group, const FrameTime&) {
          const fs::path file = log_.folder / frame.file;
          const std::string bytes = read_file(file, kLargestEntry);
          const bool is_png = bytes.starts_with("\x89PNG");
          if (!is_png && !bytes.starts_with("\xff\xd8\xff"))
            throw_input_error(file.string(), "format", "neither", "PNG or JPEG");
          out_.file(zarr_key(group, "image"), bytes, Json{{"format", is_png ? "png" : "jpeg"}});
          ++report_.pictures;
          step();
        });
  }

  template <class Step>
  void add_lidar(const LogLidar& lidar, Step& step) {
    const std::string& name = name_of(lidar.model);
    const Json intrinsics = intrinsics_of(lidar.model);
    if (intrinsics.is_null()) {
      report_.left_out.push_back(
          fmt::format("the beam table of lidar {}, of whose kind NCore has none", name));
    } else {
      out_.group(zarr_key(component("intrinsics"), "lidars/" + name), intrinsics);
    }
    const std::string at = "lidars/" + name;
    out_.group(at, attributes("lidars", name, Json{{"sensor", to_json(lidar)}}));
    const RayGrid grid(lidar.model);
    const auto is_own = [&](const SweepFrame& frame) { return frame.lidar == name; };
    add_frames(at,
               log_.sweeps,
               is_own,
               [&](const SweepFrame& frame, const std::string& group, const FrameTime& time) {
                 const Sweep sweep = read_sweep(log_.folder / frame.file, lidar.model);
                 const RayBundle rays = grid.bundle(sweep, time);
                 add_rays(group, rays, grid.lost(sweep, rays, time));
                 ++report_.sweeps;
                 step();
               });
  }

  void add_rays(const std::string& group, const RayBundle& rays, const Exact& exact) {
    const std::size_t n = rays.count();
    const std::string bundle = zarr_key(group, "ray_bundle"), returns = zarr_key(group, "ray_bundle_returns");
    out_.group(bundle, Json{{"n_rays", n}});
    out_.array(zarr_key(bundle, "direction"), {n, 3}, "<f4", view(rays.direction));
    out_.array(zarr_key(bundle, "timestamp_us"), {n}, "<u8", view(rays.timestamp_us));
    if (!rays.element.empty())
      out_.array(zarr_key(bundle, "model_element"), {n, 2}, "<u2", view(rays.element));
    out_.group(returns, Json{{"n_returns", 1}});
    out_.array(zarr_key(returns, "distance_m"), {1, n}, "<f4", view(rays.distance));
    out_.array(zarr_key(returns, "intensity"), {1, n}, "<f4", view(rays.intensity));
    std::vector<std::uint8_t> mask((n + 7) / 8, 0);
    for (std::size_t i = 0; i < n; ++i) {
      if (rays.distance[i] > 0.0F) mask[i / 8] = static_cast<std::uint8_t>(mask[i / 8] | 0x80U >> i % 8);
    }
    out_.array(
        zarr_key(group, kValidMask), {mask.size()}, "|u1", view(mask), Json{{"n_returns", 1}, {"n_rays", n}});
    if (exact.ray.empty()) return;
    const std::string ours = zarr_key(group, "generic_data");
    out_.array(zarr_key(ours, kExactRay), {exact.ray.size()}, "<u4", view(exact.ray));
    out_.array(zarr_key(ours, kExactValues), {exact.ray.size(), 4}, "<f4", view(exact.values));
  }

  /// Adds the log's masks by their file names.
  void add_masks() {
    const std::string at = component("masks");
    bool is_begun = false;
    for (const LogCamera& camera : log_.cameras) {
      std::vector<fs::path> files;
      for (const LogMask& mask : log_.masks) {
        if (mask.camera == camera.model.name) files.push_back(log_.folder / mask.file);
      }
      if (files.empty()) continue;
      if (!std::exchange(is_begun, true)) out_.group(at, attributes("masks", kOnly));
      Json names = Json::array();
      std::set<std::string> taken;
      const std::string group = zarr_key(at, "cameras/" + camera.model.name);
      for (const fs::path& file : files) {
        std::string name = file.stem().string();
        while (!taken.insert(name).second) name += "_";
        names.push_back(name);
        out_.file(zarr_key(group, name), png_of(file), Json{{"format", "png"}});
      }
      out_.group(group, Json{{"mask_names", std::move(names)}});
    }
  }

  void add_boxes() {
    Json boxes = Json::array(), rotations = Json::array(), times = Json::array();
    bool are_whole = true;
    for (const Actor& actor : log_.actors) {
      for (const KeyPose& key : actor.track) {
        const Pose pose = key.corrected();
        const Eigen::Vector3d &at = pose.translation, euler = euler_of(pose.rotation);
        const std::uint64_t time_us = clock_.us(key.time_s);
        boxes.push_back({{"track_id", actor.name},
                         {"class_id", actor.kind},
                         {"timestamp_us", time_us},
                         {"reference_frame_id", kWorld},
                         {"reference_frame_timestamp_us", time_us},
                         {"bbox3",
                          {{"centroid", {at.x(), at.y(), at.z()}},
                           {"dim", {actor.size_m.x(), actor.size_m.y(), actor.size_m.z()}},
                           {"rot", {euler.x(), euler.y(), euler.z()}}}},
                         {"source", "EXTERNAL"},
                         {"source_version", nullptr}});
        rotations.push_back(wxyz(pose.rotation));
        times.push_back(clock_.ns(key.time_s));
        are_whole = are_whole && clock_.is_whole(key.time_s);
      }
    }
    report_.boxes = boxes.size();
    Json ours{{"rotations_wxyz", std::move(rotations)}};
    if (!are_whole) ours["time_ns"] = std::move(times);
    out_.group(component("cuboids"), attributes("cuboids", kOnly, std::move(ours)));
    out_.group(zarr_key(component("cuboids"), "cuboids"),
               Json{{"cuboid_track_observations", std::move(boxes)}});
  }

  const Log& log_;
  ZarrWriter& out_;
  NcoreExport& report_;
  Clock clock_;
  double frames_first_s_ = 0.0, frames_last_s_ = 0.0;
  std::uint64_t first_us_ = 0, last_us_ = 0;
};

}  // namespace

NcoreExport export_ncore(const Log& log,
                         const fs::path& output,
                         const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::string name = output.filename().string();
  if (!name.ends_with(".zarr") && !name.ends_with(".zarr.itar"))
    throw_input_error(output.string(), "file", '"' + name + '"', "a name ending in .zarr or .zarr.itar");
  if (!has_zarr()) {
    throw_input_error(
        output.string(), "kind", "NCore, which this build can't write", "a build with libblosc and liblzma");
  }
  NcoreExport report;
  if (!log.points.empty()) report.left_out.emplace_back("points that are not LiDAR returns");
  write_zarr(output, [&](ZarrWriter& writer) { Exporter(log, writer, report).write(progress); });
  return report;
}

}  // namespace simuli
