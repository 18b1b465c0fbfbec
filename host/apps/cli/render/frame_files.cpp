#include "host/apps/cli/render/frame_files.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/draw/pictures.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/split.hpp"
#include "io/archive/npz.hpp"
#include "io/base/file.hpp"
#include "io/splat/cloud_columns.hpp"
#include "io/splat/cloud_file.hpp"

namespace simuli::cli {
namespace {

constexpr char kWorldFrame[] = "world";

/// In the world one type holds all of a path's clouds.
CloudOptions cloud_options(const FileOptions& options, const LidarModel& lidar, const Plan& plan) {
  CloudOptions cloud;
  cloud.frame = point_frame(options.cloud_frame.empty() ? kWorldFrame : options.cloud_frame);
  if (cloud.frame != PointFrame::kWorld) return cloud;
  double farthest_m = 0.0;
  for (const TimedPose& p : plan.world_from_rig.poses()) {
    farthest_m = std::max(farthest_m, p.pose.translation.norm());
  }
  cloud.coordinates = coordinates_to_a_millimetre(farthest_m + range_max(lidar));
  return cloud;
}

bool has(const std::vector<CameraOutput>& outputs, CameraOutput output) {
  return std::find(outputs.begin(), outputs.end(), output) != outputs.end();
}

/// "rgb,depth": each once.
std::vector<CameraOutput> parse_outputs(const std::string& text, bool is_camera) {
  std::vector<CameraOutput> outputs;
  for (const std::string& name : split(text, ',')) {
    const CameraOutput output = camera_output(name);
    if (!is_camera && output != CameraOutput::kRgb && output != CameraOutput::kActors &&
        output != CameraOutput::kSupport) {
      throw_usage_error("--outputs", fmt::format("\"{}\" of a LiDAR", name), "actors, support");
    }
    if (!has(outputs, output)) outputs.push_back(output);
  }
  return outputs;
}

const std::string& name_of(CameraOutput output) {
  return camera_output_names()[static_cast<std::size_t>(output)];
}

/// Metres and directions are no shares of 255.
void need_shares(const std::vector<CameraOutput>& outputs) {
  for (const CameraOutput output : outputs) {
    if (output == CameraOutput::kRgb || output == CameraOutput::kActors || output == CameraOutput::kOpacity ||
        output == CameraOutput::kSupport)
      continue;
    throw_usage_error("--values png", "the output " + name_of(output), "rgb, opacity, actors, support");
  }
}

/// Actors in 16 bits, the others as they are.
void add_array(Npz& arrays, const std::string& name, const Image& image, ColumnType type) {
  std::string bytes;
  for (const float value : image.data) {
    if (type == ColumnType::kUint16 && value > 65535.0F) {
      throw_input_error(name, "values", fmt::format("{}", value), "0 to 65535");
    }
    append_value(bytes, type, static_cast<double>(value));
  }
  std::vector<std::size_t> shape{static_cast<std::size_t>(image.height),
                                 static_cast<std::size_t>(image.width)};
  if (image.channels > 1) shape.push_back(static_cast<std::size_t>(image.channels));
  arrays.add(name, format_of(type).numpy, shape, bytes);
}

}  // namespace

void add_file_options(Command sub, FileOptions& options) {
  sub.option(
         "--images", options.images, "png, jpeg, or exr with float colours; in .mcap files png, jpeg or raw")
      .one_of({"png", "jpeg", "exr", "raw"})
      .with_default();
  sub.option("--clouds", options.clouds, "ply, pcd or npz").one_of({"ply", "pcd", "npz"}).with_default();
  sub.option(
         "--cloud-frame",
         options.cloud_frame,
         "axes of points: world; sensor, at each ray's own time; or sensor_start, without its motion since "
         "the frame's start; default: world, in .mcap files sensor")
      .one_of({"world", "sensor", "sensor_start"});
  sub.option("--outputs",
             options.outputs,
             "of cameras, parted by commas: rgb, depth, mean_depth (along z), distance, mean_distance (along "
             "the ray), opacity, actors, normals, support (how well it is known, 0 to 1); of LiDARs actors, "
             "support: columns of the clouds")
      .with_default();
  sub.option("--values",
             options.values,
             "what outputs but rgb are written as: exr, a file of floats each (actors: PNG of 16 bits); npz, "
             "one file of arrays; or png, of opacity and support, 255 being 1")
      .one_of({"exr", "npz", "png"})
      .with_default();
  sub.flag("--mark-unseen", options.mark_unseen, "hatch in pictures what no recorded camera faced");
}

FrameFiles::FrameFiles(const FileOptions& options,
                       const Sensor& sensor,
                       const Plan& plan,
                       const RecordedViews* recorded)
    : options_(options),
      is_camera_(sensor.is_camera()),
      outputs_(parse_outputs(options.outputs, is_camera_)),
      recorded_(recorded) {
  if (is_camera_) {
    if (options_.values == "png") need_shares(outputs_);
    return;
  }
  cloud_ = cloud_options(options, sensor.lidar(), plan);
  cloud_.actors = has(outputs_, CameraOutput::kActors);
}

void FrameFiles::write_outputs(const Frame& frame,
                               const std::filesystem::path& folder,
                               const std::string& stem,
                               const SupportSource* support,
                               Names& files) const {
  const auto file = [&](const std::string& ending) {
    files.push_back(stem + ending);
    return folder / files.back();
  };
  if (has(outputs_, CameraOutput::kRgb)) write_image(file("." + options_.images), shown(frame, recorded_));
  const bool is_npz = options_.values == "npz";
  Npz arrays((folder / (stem + ".npz")).string());
  std::size_t count = 0;
  for (const CameraOutput output : outputs_) {
    if (output == CameraOutput::kRgb) continue;
    ++count;
    const Image image = output == CameraOutput::kSupport && support != nullptr
                            ? support->on.image_of(frame, support->scene, support->copies)
                            : image_of(frame, output);
    const bool is_count = output == CameraOutput::kActors;
    if (is_npz) {
      add_array(arrays, name_of(output), image, is_count ? ColumnType::kUint16 : ColumnType::kFloat);
    } else if (is_count) {
      write_counts(file("_" + name_of(output) + ".png"), image);
    } else {
      write_image(file("_" + name_of(output) + "." + options_.values), image);
    }
  }
  if (is_npz && count > 0) write_file_atomically(file(".npz"), arrays.finish());
}

bool FrameFiles::needs_support() const { return has(outputs_, CameraOutput::kSupport); }

FrameFiles::Names FrameFiles::write(const Frame& frame,
                                    const std::filesystem::path& folder,
                                    const std::string& stem,
                                    const SupportSource* support) const {
  Names files;
  if (is_camera_) {
    write_outputs(frame, folder, stem, support, files);
  } else {
    files = {stem + "." + options_.clouds, stem + "_range.png"};
    CloudOptions cloud = cloud_;
    if (needs_support() && support != nullptr)
      cloud.support = support->on.of(frame, support->scene, support->copies);
    write_point_cloud(folder / files[0], point_cloud(frame, cloud));
    write_image(folder / files[1], shown(frame, recorded_));
  }
  return files;
}

void FrameFiles::describe(FramesRecord& record, const Scene& scene) const {
  if (has(outputs_, CameraOutput::kActors)) {
    for (const Actor& actor : scene.actors)
      record.actors.push_back({record.actors.size() + 1, actor.name, actor.kind});
  }
  if (is_camera_) {
    for (const CameraOutput output : outputs_) record.outputs.push_back(name_of(output));
    return;
  }
  const bool is_double = cloud_.coordinates == ColumnType::kDouble;
  record.clouds = {options_.cloud_frame.empty() ? kWorldFrame : options_.cloud_frame,
                   is_double ? "float64" : "float32"};
}

Image shown(const Frame& frame, const RecordedViews* recorded) {
  if (frame.sensor().is_camera()) {
    return recorded == nullptr ? frame.image() : with_unseen_marked(frame, *recorded).image;
  }
  const LidarFrame sweep = frame.lidar();
  return range_image(frame.sensor().lidar(), sweep.rays, sweep.range);
}

}  // namespace simuli::cli
