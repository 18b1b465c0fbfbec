#include "host/apps/cli/view/log_session.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/view/view_parts.hpp"
#include "host/core/base/activity.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/stopwatch.hpp"
#include "io/log/frame_files.hpp"
#include "io/picture/image.hpp"
#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

constexpr std::size_t kKeptBytes = std::size_t{512} << 20U;  // of cached frames, for replay

void need_recorded(const ViewRequest& request) {
  if (request.is_as_recorded()) return;
  throw_usage_error("view",
                    "another place or layer, or an edit, of a log",
                    "what was recorded; all else of a trained scene");
}

/// Returns the sensor's frame in progress at that time, or the nearest one; of several, the last.
template <class Frame>
const Frame* nearest(const std::vector<Frame>& frames,
                     const std::string Frame::*sensor,
                     const std::string& name,
                     double time_s) {
  const Frame* best = nullptr;
  const auto apart_s = [&](const Frame& f) {
    return std::max({f.time_start_s - time_s, time_s - f.time_end_s, 0.0});
  };
  for (const Frame& frame : frames) {
    if (frame.*sensor == name && (best == nullptr || apart_s(frame) <= apart_s(*best))) best = &frame;
  }
  return best;
}

}  // namespace

LogSession::LogSession(Log log)
    : log_(std::move(log)), origin_(log_.world_from_rig.poses().front().pose.translation) {
  if (!log_.files) log_.files = std::make_shared<FrameFiles>(kKeptBytes);
}

std::string LogSession::describe() const {
  Json out = json_of_drive(log_.cameras, log_.lidars, log_.world_from_rig, frame_spans(log_), origin_);
  out["kind"] = "log";
  out["name"] = log_.name;
  out["actors"] = json_of_actors(log_.actors);
  return out.dump();
}

std::string LogSession::progress() const {
  return Json{{"version", 0}, {"training", false}, {"activity", Activity::now()}}.dump();
}

const ImageFrame& LogSession::image_at(const std::string& camera, double time_s) const {
  const std::string& name = log_.camera(camera).model.name;
  const ImageFrame* const found = nearest(log_.images, &ImageFrame::camera, name, time_s);
  if (found == nullptr) throw_input_error("log", camera, "no pictures", "at least one");
  return *found;
}

const SweepFrame& LogSession::sweep_at(const std::string& lidar, double time_s) const {
  const std::string& name = name_of(log_.lidar(lidar).model);
  const SweepFrame* const found = nearest(log_.sweeps, &SweepFrame::lidar, name, time_s);
  if (found == nullptr) throw_input_error("log", lidar, "no sweeps", "at least one");
  return *found;
}

Shot LogSession::in_scene(const Shot& shot) const { return shot.relative_to(origin_); }

LogSession::Points LogSession::points_of_sweep(const SweepFrame& frame, std::size_t every) const {
  const LogLidar& lidar = log_.lidar(frame.lidar);
  Sweep sweep = read_sweep(log_, frame);
  const Shot shot = shot_of(log_, frame);
  Points out{{}, in_scene(shot).world_from_sensor_start, sweep.range.size()};
  const LidarFrame returns{std::move(sweep.rays), std::move(sweep.range), std::move(sweep.intensity), {}};
  append_points(lidar.model,
                returns,
                in_scene(shot),
                log_.actors,
                actors_during(log_.actors, shot, origin_),
                every,
                out.values);
  return out;
}

std::vector<float> LogSession::points_over(const ImageFrame& image,
                                           const Camera& camera,
                                           const std::string& lidar) const {
  const double middle_s = 0.5 * (image.time_start_s + image.time_end_s);
  return seen_points(
      camera, in_scene(shot_of(log_, image)), points_of_sweep(sweep_at(lidar, middle_s), 1).values);
}

std::string LogSession::picture(const ViewRequest& request) {
  need_recorded(request);
  const Stopwatch reading;
  const ImageFrame& frame = image_at(request.sensor, request.time_s);
  const Camera& own = log_.camera(frame.camera).model;
  const double scale = std::min(1.0, static_cast<double>(request.width) / own.width);
  const Camera camera = scaled_camera(own, scale);
  Image image = load_image(log_, frame, camera);
  for (float& value : image.data) value = std::max(value, 0.0F);  // masked pixels are black
  const Shot shot = shot_of(log_, frame);
  const std::vector<float> points =
      request.points.empty() ? std::vector<float>() : points_over(frame, camera, request.points);
  const double reading_ms = reading.ms();
  const Stopwatch encode;
  const std::string bytes = with_points(
      points, encode_image(image, request.lossless ? ImageCode::kPng : ImageCode::kJpeg, kJpegQuality));
  const Json boxes =
      json_of_outlines(camera, in_scene(shot), log_.actors, actors_during(log_.actors, shot, origin_));
  return reply({{"render_ms", reading_ms},
                {"encode_ms", encode.ms()},
                {"time_s", frame.time_start_s},
                {"scene_from_camera", json_of(in_scene(shot).pose_at(0.5))},
                {"boxes", boxes},
                {"points", points.size() / kSeenValues}},
               bytes.data(),
               bytes.size());
}

std::string LogSession::sweep(const ViewRequest& request) {
  need_recorded(request);
  const Stopwatch reading;
  const SweepFrame& now = sweep_at(request.sensor, request.time_s);
  std::vector<const SweepFrame*> frames{&now};
  if (request.sweeps > 1) {
    std::vector<const SweepFrame*> own;
    for (const SweepFrame& f : log_.sweeps) {
      if (f.lidar == now.lidar) own.push_back(&f);
    }
    const std::size_t wanted = std::min(own.size(), static_cast<std::size_t>(request.sweeps));
    frames.clear();
    for (std::size_t i = 0; i < wanted; ++i) frames.push_back(own[i * own.size() / wanted]);
  }
  const Shot shot = shot_of(log_, now);
  const std::size_t rays = read_sweep(log_, now).range.size();
  const std::size_t every = (rays * frames.size() + kMostReturns - 1) / kMostReturns;
  std::vector<float> points;
  for (const SweepFrame* const frame : frames) {
    const std::vector<float> some = points_of_sweep(*frame, every).values;
    points.insert(points.end(), some.begin(), some.end());
  }
  return reply({{"render_ms", reading.ms()},
                {"rays", rays * frames.size()},
                {"every", every},
                {"sweeps", frames.size()},
                {"time_s", now.time_start_s},
                {"scene_from_sensor", json_of(in_scene(shot).world_from_sensor_start)},
                {"actors", json_of_boxes(log_.actors, actors_during(log_.actors, shot, origin_))}},
               points.data(),
               points.size() * sizeof(float));
}

std::string LogSession::probe(const ViewRequest& request) {
  need_recorded(request);
  if (!request.pixel) throw_input_error("request", "pixel", "none", "a place in the picture");
  constexpr double kNear = 0.01;  // share of the picture's width
  const ImageFrame& frame = image_at(request.sensor, request.time_s);
  const Camera& camera = log_.camera(frame.camera).model;
  Json out = {{"distance_m", nullptr},
              {"intensity", nullptr},
              {"ring", nullptr},
              {"point", nullptr},
              {"actor", nullptr}};
  if (request.points.empty()) return out.dump();
  const std::vector<float> points = points_over(frame, camera, request.points);
  const Eigen::Vector3d eye = in_scene(shot_of(log_, frame)).pose_at(0.5).translation;
  double least = kNear;
  for (auto p = points.begin(); p != points.end(); p += kSeenValues) {
    const Eigen::Vector2d apart = Eigen::Vector2d(p[kPointValues], p[kPointValues + 1]) - *request.pixel;
    const double away = std::hypot(apart.x(), apart.y() * camera.height / camera.width);
    if (away >= least) continue;
    least = away;
    const Eigen::Vector3d point(p[0], p[1], p[2]);
    out = {{"distance_m", (point - eye).norm()},
           {"intensity", p[3]},
           {"ring", p[4]},
           {"point", json_of(point)},
           {"actor", nullptr}};
    if (p[6] > 0.0F) out["actor"] = log_.actors.at(static_cast<std::size_t>(p[6]) - 1).name;
  }
  return out.dump();
}

}  // namespace simuli::cli
