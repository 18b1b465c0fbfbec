#include "host/apps/cli/render/frame_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <optional>

#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/draw/pictures.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/split.hpp"
#include "host/device/render/outputs/flow.hpp"
#include "io/archive/npz.hpp"
#include "io/base/file.hpp"
#include "io/export/frame_labels.hpp"
#include "io/splat/cloud_columns.hpp"
#include "io/splat/cloud_file.hpp"

namespace simuli::cli {
namespace {

constexpr char kWorldFrame[] = "world";

/// Returns the options of clouds; in the world frame all clouds of a trajectory have the same element type.
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

/// Returns the class of each actor, numbered from 1; actors of one kind share a class.
std::vector<std::uint16_t> classes_of(const Scene& scene) {
  std::vector<std::string> kinds;
  std::vector<std::uint16_t> out;
  for (const Actor& actor : scene.actors) {
    const auto known = std::find(kinds.begin(), kinds.end(), actor.kind);
    out.push_back(static_cast<std::uint16_t>(known - kinds.begin() + 1));
    if (known == kinds.end()) kinds.push_back(actor.kind);
  }
  return out;
}

/// Returns a sweep in nuScenes' format: x, y, z (m, in the sensor's axes at the sweep's end), intensity 0 to
/// 255, and ring, counted from the lowest beam.
std::string nuscenes_sweep(const Frame& frame) {
  const LidarFrame sweep = frame.lidar();
  const Shot& shot = frame.shot();
  const Pose end_from_start = shot.world_from_sensor_end.inverse() * shot.world_from_sensor_start;
  const std::vector<Eigen::Vector3d> points = frame.points(PointFrame::kSensorStart);
  const std::size_t rows = frame.sensor().rows(), columns = frame.sensor().columns();
  std::string bytes;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!sweep.is_return(i)) continue;
    const Eigen::Vector3d p = end_from_start * points[i];
    const auto ring = static_cast<double>(rows - 1 - i / columns);
    for (const double value : {p.x(), p.y(), p.z(), 255.0 * static_cast<double>(sweep.intensity[i]), ring})
      append_value(bytes, ColumnType::kFloat, value);
  }
  return bytes;
}

/// Parses "rgb,depth"; each output may occur once.
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

bool is_flow(CameraOutput output) {
  return output == CameraOutput::kFlow || output == CameraOutput::kSceneFlow;
}

/// Converts Flow::pixels to KITTI's encoding: 64ths of a pixel from -512, and a validity flag. Vectors beyond
/// its range are invalid.
Image kitti_flow(Image flow) {
  for (std::size_t i = 0; i < flow.data.size(); i += 3) {
    float* const pixel = &flow.data[i];
    const float x = std::round(64.0F * pixel[0]) + 32768.0F, y = std::round(64.0F * pixel[1]) + 32768.0F;
    const bool is_valid = pixel[2] > 0.0F && std::min(x, y) >= 0.0F && std::max(x, y) <= 65535.0F;
    pixel[0] = is_valid ? x : 0.0F;
    pixel[1] = is_valid ? y : 0.0F;
    pixel[2] = is_valid ? 1.0F : 0.0F;
  }
  return flow;
}

/// Throws Error{kUsage} for outputs in metres or directions, which cannot be stored as shares of 255.
void need_shares(const std::vector<CameraOutput>& outputs) {
  for (const CameraOutput output : outputs) {
    if (output == CameraOutput::kRgb || output == CameraOutput::kActors || output == CameraOutput::kOpacity ||
        output == CameraOutput::kSupport || output == CameraOutput::kFlow)
      continue;
    throw_usage_error("--values png", "the output " + name_of(output), "rgb, opacity, actors, support, flow");
  }
}

/// Adds an array; actor numbers are stored in 16 bits, other values unchanged.
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
             "outputs of cameras, comma-separated: rgb, depth, mean_depth (along z), distance, "
             "mean_distance (along the ray), opacity, actors, normals, support (by the training frames, 0 "
             "to 1), flow (px) and scene_flow (m) to the next frame; of LiDARs actors, support: columns of "
             "the clouds")
      .with_default();
  sub.option("--values",
             options.values,
             "format of outputs except rgb: exr, one float file each (actors: PNG of 16 bits); npz, one "
             "file of arrays; or png, for opacity and support with 255 for 1, and for flow in KITTI's "
             "encoding")
      .one_of({"exr", "npz", "png"})
      .with_default();
  sub.option("--labels",
             options.labels,
             "boxes, truncation, occlusion, pixels or returns of actors in frames.json (json), and in the "
             "format of KITTI, COCO or nuScenes")
      .one_of({"json", "kitti", "coco", "nuscenes"});
  sub.flag("--mark-unseen", options.mark_unseen, "hatch pixels that no recorded camera faced");
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
    const auto flow = std::find_if(outputs_.begin(), outputs_.end(), is_flow);
    if (flow != outputs_.end() && plan.spans.size() < 2)
      throw_usage_error("--outputs", name_of(*flow) + " of one frame", "with a frame behind it to lead to");
    const bool has_files = !options_.labels.empty() && options_.labels != "json";
    if (has_files && !has(outputs_, CameraOutput::kRgb))
      throw_usage_error("--labels", options_.labels + " without pictures", "with rgb among --outputs");
    if (options_.labels == "kitti" && options_.images != "png")
      throw_usage_error("--labels", "kitti with --images " + options_.images, "with --images png");
    return;
  }
  cloud_ = cloud_options(options, sensor.lidar(), plan);
  cloud_.actors = has(outputs_, CameraOutput::kActors);
}

void FrameFiles::write_outputs(const Frame& frame,
                               const std::filesystem::path& folder,
                               const std::string& stem,
                               const FrameSources& sources,
                               const Shot* next,
                               FrameRecord& record) const {
  const auto file = [&](const std::string& ending) {
    record.files.push_back(stem + ending);
    return folder / record.files.back();
  };
  if (has(outputs_, CameraOutput::kRgb)) {
    write_image(file("." + options_.images), shown(frame, recorded_));
    record.data = record.files.back();
  }
  std::optional<Flow> flow;
  if (next != nullptr && std::any_of(outputs_.begin(), outputs_.end(), is_flow))
    flow = flow_of(frame, sources.scene, *next);
  const bool is_npz = options_.values == "npz";
  Npz arrays((folder / (stem + ".npz")).string());
  std::size_t count = 0;
  for (const CameraOutput output : outputs_) {
    if (output == CameraOutput::kRgb || (is_flow(output) && !flow)) continue;
    ++count;
    const Image image = output == CameraOutput::kSupport && sources.support != nullptr
                            ? sources.support->image_of(frame, sources.scene, sources.copies)
                        : is_flow(output) ? (output == CameraOutput::kFlow ? flow->pixels : flow->points)
                                          : image_of(frame, output);
    const bool is_count = output == CameraOutput::kActors;
    if (is_npz) {
      add_array(arrays, name_of(output), image, is_count ? ColumnType::kUint16 : ColumnType::kFloat);
    } else if (is_count) {
      write_counts(file("_" + name_of(output) + ".png"), image);
    } else if (output == CameraOutput::kFlow && options_.values == "png") {
      write_counts(file("_flow.png"), kitti_flow(image));
    } else {
      write_image(file("_" + name_of(output) + "." + options_.values), image);
    }
  }
  if (is_npz && count > 0) write_file_atomically(file(".npz"), arrays.finish());
}

bool FrameFiles::needs_support() const { return has(outputs_, CameraOutput::kSupport); }

void FrameFiles::write_cloud(const Frame& frame,
                             const std::filesystem::path& folder,
                             const std::string& stem,
                             const FrameSources& sources,
                             FrameRecord& record) const {
  record.files = {stem + "." + options_.clouds, stem + "_range.png"};
  CloudOptions cloud = cloud_;
  if (needs_support() && sources.support != nullptr)
    cloud.support = sources.support->of(frame, sources.scene, sources.copies);
  if (cloud.actors) cloud.classes = classes_of(sources.scene);
  write_point_cloud(folder / record.files[0], point_cloud(frame, cloud));
  write_image(folder / record.files[1], shown(frame, recorded_));
  if (options_.labels != "nuscenes") return;
  record.data = stem + ".pcd.bin";
  record.files.push_back(record.data);
  write_file_atomically(folder / record.data, nuscenes_sweep(frame));
}

FrameRecord FrameFiles::write(const Frame& frame,
                              const std::filesystem::path& folder,
                              const std::string& stem,
                              const FrameSources& sources,
                              const Shot* next) const {
  const Shot& shot = frame.shot();
  FrameRecord record{.time_start_s = shot.time_start_s,
                     .time_end_s = shot.time_end_s,
                     .world_from_sensor_start = shot.world_from_sensor_start,
                     .world_from_sensor_end = shot.world_from_sensor_end};
  if (is_camera_) {
    write_outputs(frame, folder, stem, sources, next, record);
  } else {
    write_cloud(frame, folder, stem, sources, record);
  }
  if (sources.labels != nullptr) record.labels = sources.labels->of(frame);
  return record;
}

void FrameFiles::describe(FramesRecord& record, const Scene& scene) const {
  record.has_labels = !options_.labels.empty();
  if (has(outputs_, CameraOutput::kActors) || record.has_labels) {
    const std::vector<std::uint16_t> classes = classes_of(scene);
    for (std::size_t i = 0; i < classes.size(); ++i)
      record.actors.push_back({i + 1, scene.actors[i].name, scene.actors[i].kind, classes[i]});
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
