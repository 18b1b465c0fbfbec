#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/apps/cli/draw/depth_picture.hpp"
#include "host/apps/cli/draw/pictures.hpp"
#include "host/apps/cli/draw/unseen.hpp"
#include "host/apps/cli/report/report_parts.hpp"
#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

constexpr std::array kLaneShifts_m{2.0, -2.0};  // m to the left
constexpr double kAside_m = 3.0;                // distance from an actor

/// A recorded picture to render again.
struct Take {
  const ImageFrame* frame;
  Sensor camera;
  Shot shot;
};

Take take_of(const Evaluation& evaluation, const ImageFrame& frame) {
  const Log& log = evaluation.log();
  const LogCamera& camera = log.camera(frame.camera);
  return {
      &frame,
      Sensor(scaled_camera(camera.model, evaluation.frames().requested.image_scale), camera.rig_from_camera),
      shot_of(log, frame)};
}

/// Returns the compared frames of the log's first camera that has any.
std::vector<const ImageFrame*> frames_of_first_camera(const Evaluation& evaluation) {
  const Log& log = evaluation.log();
  for (const LogCamera& camera : log.cameras) {
    std::vector<const ImageFrame*> frames;
    for (const std::size_t index : evaluation.frames().images) {
      if (log.images[index].camera == camera.model.name) frames.push_back(&log.images[index]);
    }
    if (!frames.empty()) return frames;
  }
  return {};
}

/// Adds a picture, with pixels marked that no recorded camera faced.
class Album {
 public:
  Album(HtmlReport& html, const Evaluation& evaluation, SceneOnDevice& scene)
      : html_(html), scene_(scene), views_(evaluation.scene()) {}
  void add(const Sensor& camera, const Shot& shot, const std::string& caption) {
    constexpr double kLeastShare = 5e-4;
    const MarkedPicture picture =
        with_unseen_marked(scene_.render(camera, shot, {.camera_median = true}), views_);
    const std::string marked =
        picture.unseen_share > kLeastShare
            ? fmt::format("; hatched: {:.1f} % that no recorded camera faced", 100.0 * picture.unseen_share)
            : "";
    html_.picture(picture.image, caption + marked, PictureCode::kPhoto);
  }
  void add_depth(const Sensor& camera, const Shot& shot, const std::string& caption) {
    const DepthPicture depth = depth_picture(scene_.render(camera, shot, {.camera_median = true}));
    html_.picture(
        depth.image,
        fmt::format("{}: depth, {:g} m pale to {:g} m blue, on a logarithmic scale; black: no surface",
                    caption,
                    depth.near_m,
                    depth.far_m),
        PictureCode::kPhoto);
  }

 private:
  HtmlReport& html_;
  SceneOnDevice& scene_;
  RecordedViews views_;
};

/// An actor and the picture in which it is largest.
struct Appearance {
  std::string actor;
  const ImageFrame* frame = nullptr;
};
std::optional<Appearance> largest_actor(const Evaluation& evaluation,
                                        const std::vector<const ImageFrame*>& frames) {
  const std::vector<Actor>& actors = evaluation.scene().scene.actors;
  std::optional<Appearance> largest;
  double most_rad = 0.0;
  for (const ImageFrame* frame : frames) {
    const Take take = take_of(evaluation, *frame);
    const Pose camera_from_world = take.shot.world_from_sensor_start.inverse();
    const Camera& model = take.camera.camera();
    for (const Actor& actor : actors) {
      if (actor.track.empty() || !actor.is_there(frame->time_start_s)) continue;
      const Eigen::Vector3d p_camera = camera_from_world * actor.at(frame->time_start_s).translation;
      Eigen::Vector2d pixel;
      if (!model.project(p_camera, pixel)) continue;
      if (pixel.x() < 0.0 || pixel.x() > model.width || pixel.y() < 0.0 || pixel.y() > model.height) continue;
      const double angle_rad = actor.size_m.norm() / std::max(p_camera.norm(), actor.size_m.norm());
      if (!(angle_rad > most_rad)) continue;
      most_rad = angle_rad;
      largest = {actor.name, frame};
    }
  }
  return largest;
}

std::string name_of_frame(const ImageFrame& frame) {
  return fmt::format("{}, {:.2f} s", frame.camera, frame.time_start_s);
}

void add_lanes(Album& album, const Take& take, const std::string& name) {
  for (const double left_m : kLaneShifts_m) {
    album.add(take.camera,
              take.shot.shifted_left(take.camera.rig_from_sensor(), left_m),
              fmt::format("{}, the rig {:g} m to the {} of where it drove",
                          name,
                          std::abs(left_m),
                          left_m > 0.0 ? "left" : "right"));
  }
}

void add_edits(Album& album, const Evaluation& evaluation, const Appearance& seen) {
  const Take take = take_of(evaluation, *seen.frame);
  const std::string name = name_of_frame(*seen.frame);
  Shot edited = take.shot;
  edited.edits = {{seen.actor, ActorEdit::Remove{}}};
  album.add(take.camera, edited, fmt::format("{}, without {} (--remove {})", name, seen.actor, seen.actor));
  edited.edits = {{seen.actor, ActorEdit::Move{Eigen::Vector3d(0.0, -kAside_m, 0.0)}}};
  album.add(take.camera,
            edited,
            fmt::format("{}, {} {:g} m to its right (--move {}:0,{:g},0)",
                        name,
                        seen.actor,
                        kAside_m,
                        seen.actor,
                        -kAside_m));
}

/// Adds a wide lens in place of the camera, unless the camera has one.
void add_lens(Album& album, const Take& take, const std::string& name) {
  constexpr double kWide_rad = 150.0 / 180.0 * std::numbers::pi;
  constexpr const char* kLens = "gsplat_camera_front_fisheye_140fov";
  if (view_angle(take.camera.camera()).horizontal_rad > kWide_rad) return;
  const Camera lens = builtin_camera(kLens);
  const int width = std::clamp(take.camera.camera().width, 640, 960);
  const Sensor sensor(lens.resized(width, static_cast<int>(std::lround(width * lens.height / lens.width))),
                      take.camera.rig_from_sensor());
  album.add(sensor, take.shot, fmt::format("{}, through another lens ({})", name, kLens));
}

}  // namespace

void add_unrecorded(HtmlReport& html, Evaluation& evaluation, SceneOnDevice& scene) {
  const std::vector<const ImageFrame*> frames = frames_of_first_camera(evaluation);
  const bool has_pictures = !frames.empty() && scene.scene().camera.size() > 0;
  add_sweep_cloud(html, evaluation, scene);
  if (!has_pictures) return;
  const ImageFrame& frame = *frames[frames.size() / 2];
  const Take take = take_of(evaluation, frame);
  const std::string name = name_of_frame(frame);
  html.heading("Cameras beyond the recording");
  html.paragraph("Rendered; nothing was recorded to compare with.");
  Album album(html, evaluation, scene);
  album.add_depth(take.camera, take.shot, name);
  add_lanes(album, take, name);
  if (const auto seen = largest_actor(evaluation, frames)) add_edits(album, evaluation, *seen);
  add_lens(album, take, name);
}

}  // namespace simuli::cli
