#include "io/import/ncore/ncore_log.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/base/file.hpp"
#include "io/import/ncore/ncore_sequence.hpp"
#include "io/log/log_json.hpp"
#include "io/log/new_log.hpp"
#include "io/ncore/models.hpp"
#include "io/picture/sized_image.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace ncore;

class Importer {
 public:
  Importer(const NcoreOptions& options, NcoreReport& report)
      : options_(options), report_(report), sequence_(options.sequence) {
    const std::vector<std::string> all = sequence_.in_order("lidars");
    const auto cameras = requested_sensors(options.cameras, sequence_.in_order("cameras"), "--cameras");
    const auto lidars = requested_sensors(options.lidars, all, "--lidars");
    for (const auto& [name, table] : options.tables) (void)index_of_name(name, all, "--lidar");
    path_ = sequence_.path(options.world_frame, options.rig_frame);
    log_.name = name_from(sequence_.id());
    log_.start_ns = sequence_.clock().start_ns();
    log_.world_from_rig = path_.trajectory;
    for (const std::string& name : cameras) add_camera(name);
    for (const std::string& name : lidars) add_lidar(name);
    if (log_.cameras.empty() && log_.lidars.empty())
      throw_nothing_left(sequence_.file(), "sensors", "none that can be used", "at least one");
    for (const char* const kind : {"radars", "point_clouds", "camera_labels"}) {
      const std::size_t count = sequence_.instances(kind).size();
      if (count > 0) report_.notes.push_back(fmt::format("left out: {} {}", count, kind));
    }
    log_.actors =
        actors_of(sequence_, path_, options.world_frame, options.rig_frame, report_.unposed, report_.labels);
  }

  Log write(const FrameProgress& progress) {
    std::size_t total = 0;
    for (const LogCamera& camera : log_.cameras) total += frames_of("cameras", camera.model.name).size();
    for (const LogLidar& lidar : log_.lidars) total += frames_of("lidars", name_of(lidar.model)).size();
    return make_import(options_.output, log_, [&] {
      LogMaker maker(log_, progress, total);
      for (const LogCamera& camera : log_.cameras) add_pictures(camera.model, maker);
      for (LogLidar& lidar : log_.lidars) add_sweeps(lidar, maker);
      for (const LogCamera& camera : log_.cameras) add_masks(camera.model.name);
      report_.rays = maker.rays();
      report_.returned = maker.returned();
    });
  }

 private:
  [[nodiscard]] const ZarrGroup& place(const char* kind, const std::string& name) const {
    return sequence_.instances(kind).at(name);
  }
  [[nodiscard]] std::vector<FrameTime> frames_of(const char* kind, const std::string& name) const {
    return Sequence::frames(place(kind, name));
  }

  void leave_out(const std::string& what, const std::string& why) {
    report_.notes.push_back(fmt::format("left out: {}: {}", what, why));
  }

  /// Returns a sensor's mounting, as stored by export_ncore() if it agrees with the file's.
  template <class Sensor>
  [[nodiscard]] bool mount(const std::string& name,
                           Pose& rig_from_sensor,
                           const Sensor* exact,
                           Pose Sensor::*own) {
    const auto found = sequence_.poses().fixed(options_.rig_frame, name);
    if (!found) return false;
    rig_from_sensor = *found;
    constexpr double kRounding = 1e-12;
    if (exact != nullptr && (exact->*own).matrix().isApprox(found->matrix(), kRounding))
      rig_from_sensor = exact->*own;
    return true;
  }

  /// Returns the sensor that export_ncore() stored at a component; ignores damaged data.
  template <class Read>
  [[nodiscard]] auto left_sensor(const ZarrGroup& at, const Read& read) const
      -> std::optional<decltype(read(std::declval<JsonObject&>()))> {
    const Json ours = ours_of(at.attributes());
    const auto found = ours.find("sensor");
    if (found == ours.end() || !found->is_object()) return std::nullopt;
    try {
      JsonObject object(at.file(), "simuli.sensor", *found);
      return object.read_and_finish(read);
    } catch (const Error&) {
      return std::nullopt;
    }
  }

  void add_camera(const std::string& name) {
    const auto at = sequence_.find("intrinsics", "cameras/" + name);
    if (!at) return leave_out("camera " + name, "no intrinsics");
    need_name(name, sequence_.file(), "cameras");
    const Json attributes = at->attributes();
    JsonObject intrinsics(at->file(), "", attributes);
    LogCamera camera;
    camera.model = camera_from_intrinsics(intrinsics, name);
    const auto exact = left_sensor(place("cameras", name), camera_from_json);
    const bool is_exact =
        exact && exact->model.name == name && is_same(intrinsics_of(exact->model), attributes);
    if (is_exact) camera.model = exact->model;
    if (!mount(name, camera.rig_from_camera, exact ? &*exact : nullptr, &LogCamera::rig_from_camera))
      return leave_out("camera " + name, "no pose on the rig");
    log_.cameras.push_back(std::move(camera));
  }

  void add_lidar(const std::string& name) {
    need_name(name, sequence_.file(), "lidars");
    LogLidar lidar;
    const auto at = sequence_.find("intrinsics", "lidars/" + name);
    const auto exact = left_sensor(place("lidars", name), lidar_from_json);
    const auto table = options_.tables.find(name);
    if (table != options_.tables.end()) {
      Lidar model = table->second;
      model.name = name;
      lidar.model = std::move(model);
    } else if (at) {
      const Json attributes = at->attributes();
      JsonObject intrinsics(at->file(), "", attributes);
      Lidar model = lidar_from_intrinsics(intrinsics, name);
      const bool is_exact =
          exact && name_of(exact->model) == name && is_same(intrinsics_of(exact->model), attributes);
      if (is_exact) {
        lidar.model = exact->model;
      } else {
        lidar.model = std::move(model);
        without_range_.push_back(name);
      }
    } else if (exact && name_of(exact->model) == name && intrinsics_of(exact->model).is_null()) {
      lidar.model = exact->model;
    } else {
      throw_input_error(sequence_.file(),
                        "lidars/" + name,
                        "no intrinsics",
                        fmt::format("--lidar {}=SENSOR, or --lidars without it", name));
    }
    if (!mount(name, lidar.rig_from_lidar, exact ? &*exact : nullptr, &LogLidar::rig_from_lidar))
      return leave_out("lidar " + name, "no pose on the rig");
    log_.lidars.push_back(std::move(lidar));
  }

  /// Returns the times of a frame in the log; false for times outside the trajectory.
  bool span(const ZarrGroup& frame, const FrameTime& time, FrameSpan& out) {
    const Json meta = (frame / "generic_data").attributes();
    const auto ours = meta.find("simuli");
    const std::vector<double> times_s = sequence_.times_of(
        {time.start_us, time.end_us}, ours != meta.end() && ours->is_object() ? *ours : Json::object());
    out = {times_s[0], times_s[1]};
    const bool is_posed = out.time_start_s >= path_.first_s && out.time_end_s <= path_.last_s;
    if (!is_posed) ++report_.unposed;
    return is_posed;
  }

  void add_pictures(const Camera& camera, LogMaker& maker) {
    std::size_t number = 0;
    for (const FrameTime& time : frames_of("cameras", camera.name)) {
      maker.step();
      const ZarrGroup frame = place("cameras", camera.name) / fmt::format("frames/{}", time.end_us),
                      image = frame / "image";
      FrameSpan times;
      if (!span(frame, time, times)) continue;
      // NCore's global shutter exposes the whole picture at the start.
      if (camera.shutter == ShutterKind::kGlobal) times.time_end_s = times.time_start_s;
      const std::string bytes = read_zarr_array(*image.store, image.path).bytes;
      const bool is_png = bytes.starts_with("\x89PNG");
      if (!is_png && !bytes.starts_with("\xff\xd8\xff"))
        throw_input_error(image.file(), "format", "neither", "PNG or JPEG");
      const std::string file =
          fmt::format("images/{}_{:06}.{}", camera.name, number++, is_png ? "png" : "jpg");
      put_file(log_, file, [&](const fs::path& to) {
        write_file_atomically(to, bytes);
        (void)with_context("reading " + image.file(),
                           [&] { return read_image(to, camera.width, camera.height, "its intrinsics"); });
      });
      log_.images.push_back({camera.name, file, times.time_start_s, times.time_end_s});
    }
  }

  void add_sweeps(LogLidar& lidar, LogMaker& maker) {
    const std::string name = name_of(lidar.model);
    const bool by_table = options_.tables.contains(name);
    const RayGrid grid(lidar.model);
    float farthest = 0.0F;
    std::size_t number = 0;
    for (const FrameTime& time : frames_of("lidars", name)) {
      maker.step();
      const ZarrGroup frame = place("lidars", name) / fmt::format("frames/{}", time.end_us);
      FrameSpan times;
      if (!span(frame, time, times)) continue;
      if (time.end_us == time.start_us) throw_input_error(frame.file(), "end", "its start", "a later time");
      const RayBundle rays = read_rays(frame, report_.echoes);
      Sweep sweep;
      if (by_table || (rays.element.empty() && rays.count() != ray_count(lidar.model))) {
        sweep = placed(rays, time, lidar.with_rows());
      } else {
        sweep = grid.sweep(rays, time, frame.file(), report_.twice);
        grid.restore(read_exact(frame), sweep);
      }
      for (std::size_t i = 0; i < sweep.range.size(); ++i) {
        if (!(sweep.range[i] > 0.0F)) continue;
        farthest = std::max(farthest, sweep.range[i]);
        sweep.range[i] = stated_range(lidar.model, sweep.rays, i, sweep.range[i]);
      }
      maker.add_sweep(name, fmt::format("{}_{:06}", name, number++), sweep, times);
    }
    if (std::find(without_range_.begin(), without_range_.end(), name) == without_range_.end()) return;
    auto& model = std::get<Lidar>(lidar.model);
    model.range_max = std::max(1.0, std::ceil(static_cast<double>(farthest)));
    report_.notes.push_back(fmt::format(
        "lidar {}: NCore has no range and no divergence: using {} m, its farthest return, and ideal rays",
        name,
        model.range_max));
  }

  /// Assigns rays without element indices to the beams of a table.
  Sweep placed(const RayBundle& rays, const FrameTime& time, const Lidar& table) {
    std::vector<MeasuredPoint> points;
    const auto duration = static_cast<double>(time.end_us - time.start_us);
    for (std::size_t i = 0; i < rays.count(); ++i) {
      if (!(rays.distance[i] > 0.0F)) continue;
      const Eigen::Vector3d direction(
          rays.direction[3 * i], rays.direction[3 * i + 1], rays.direction[3 * i + 2]);
      const double after =
          static_cast<double>(static_cast<std::int64_t>(rays.timestamp_us[i] - time.start_us));
      points.push_back(
          {rays.distance[i] * direction, rays.intensity[i], -1, std::clamp(after / duration, 0.0, 1.0)});
    }
    return grid_points(points, table, report_.points);
  }

  void add_masks(const std::string& camera) {
    const auto at = sequence_.find("masks", "cameras/" + camera);
    if (!at) return;
    for (const std::string& name : at->store->children(at->path)) {
      need_name(name, at->file(), "mask_names");
      const std::string bytes = read_zarr_array(*at->store, (*at / name).path).bytes;
      if (!bytes.starts_with("\x89PNG")) throw_input_error((*at / name).file(), "format", "another", "PNG");
      const std::string file = fmt::format("masks/{}/{}.png", camera, name);
      put_file(log_, file, [&](const fs::path& to) { write_file_atomically(to, bytes); });
      log_.masks.push_back({camera, file});
      report_.notes.push_back(fmt::format(
          "mask {} of camera {}: pictures are neither learned from nor compared where {} is not 0",
          name,
          camera,
          file));
    }
  }

  const NcoreOptions& options_;
  NcoreReport& report_;
  Sequence sequence_;
  Sequence::Path path_;
  std::vector<std::string> without_range_;
  Log log_;
};

}  // namespace

Log import_ncore(const NcoreOptions& options, const FrameProgress& progress, NcoreReport& report) {
  return Importer(options, report).write(progress);
}

}  // namespace simuli
