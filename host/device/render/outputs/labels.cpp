#include "host/device/render/outputs/labels.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/scene/particle_order.hpp"
#include "host/core/sensors/lidar_locate.hpp"
#include "host/core/sensors/own_time.hpp"
#include "host/device/render/scene/actor_boxes.hpp"
#include "host/device/render/scene/frame_state.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

GaussianSet of_actors(const GaussianSet& set, std::size_t actors) {
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < set.actor.size(); ++i) {
    if (set.actor[i] > 0 && set.actor[i] <= actors) rows.push_back(static_cast<Eigen::Index>(i));
  }
  return subset(set, rows);
}

Scene without_background(const Scene& scene) {
  Scene out;
  out.origin = scene.origin;
  out.camera = of_actors(scene.camera, scene.actors.size());
  out.lidar = of_actors(scene.lidar, scene.actors.size());
  out.actors = scene.actors;
  out.ray_drop = scene.ray_drop;
  out.camera_filter_px2 = scene.camera_filter_px2;
  return out;
}

/// [rays] 1 + the actor whose body ends the ray; for LiDARs only returned rays.
std::vector<std::uint32_t> bodies_in(const Frame& frame) {
  std::vector<std::uint32_t> actors = frame.actors();
  if (frame.sensor().is_camera()) return actors;
  const LidarFrame sweep = frame.lidar();
  for (std::size_t i = 0; i < actors.size(); ++i) {
    if (!sweep.is_return(i)) actors[i] = 0;
  }
  return actors;
}

/// Points on the faces and edges of a box, denser along the edges: lenses bend the edges that bound a box's
/// image.
struct SurfacePoints {
  std::vector<Vector3d> faces, edges;
};
SurfacePoints points_on_box(const Vector3d& half) {
  constexpr int kAcross = 8, kAlong = 32;
  SurfacePoints out;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Index a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (const double side : {-1.0, 1.0}) {
      Vector3d p;
      p[axis] = side * half[axis];
      for (int i = 0; i < kAcross * kAcross; ++i) {
        p[a] = half[a] * (2.0 * (i % kAcross + 0.5) / kAcross - 1.0);
        p[b] = half[b] * (2.0 * (i / kAcross + 0.5) / kAcross - 1.0);
        out.faces.push_back(p);
      }
      for (const double other : {-1.0, 1.0}) {
        p[a] = other * half[a];
        for (int i = 0; i <= kAlong; ++i) {
          p[b] = half[b] * (2.0 * i / kAlong - 1.0);
          out.edges.push_back(p);
        }
      }
    }
  }
  return out;
}

void take_in(const Eigen::Vector2d& low, const Eigen::Vector2d& high, std::optional<PixelBox>& box) {
  if (!box) box = PixelBox{low.x(), low.y(), high.x(), high.y()};
  box->left = std::min(box->left, low.x()), box->right = std::max(box->right, high.x());
  box->top = std::min(box->top, low.y()), box->bottom = std::max(box->bottom, high.y());
}

/// Sets the label's projected box.
void project_box(const Camera& camera, const ActorBoxes& boxes, ActorLabel& label) {
  const SurfacePoints points = points_on_box(boxes.half_m(label.actor));
  const auto image_of = [&](const Vector3d& p_actor) {
    return image_at_own_time(camera, [&](double share) -> Vector3d {
      return boxes.actor_from_sensor(label.actor, share).inverse() * p_actor;
    });
  };
  std::optional<PixelBox> box;
  std::size_t inside = 0;
  for (const Vector3d& p : points.faces) {
    const std::optional<OwnTimeImage> image = image_of(p);
    if (!image) continue;
    const Eigen::Vector2d& at = image->pixel;
    take_in(at, at, box);
    inside += at.x() >= 0.0 && at.x() < camera.width && at.y() >= 0.0 && at.y() < camera.height ? 1U : 0U;
  }
  for (const Vector3d& p : points.edges) {
    if (const std::optional<OwnTimeImage> image = image_of(p)) take_in(image->pixel, image->pixel, box);
  }
  label.truncation = 1.0 - static_cast<double>(inside) / static_cast<double>(points.faces.size());
  if (!box) return;
  const PixelBox clipped{std::max(box->left, 0.0),
                         std::max(box->top, 0.0),
                         std::min<double>(box->right, camera.width),
                         std::min<double>(box->bottom, camera.height)};
  if (clipped.left < clipped.right && clipped.top < clipped.bottom) label.projected_px = clipped;
}

/// Sets the label's mask.
void add_mask(const std::vector<std::uint32_t>& bodies, const Camera& camera, ActorLabel& label) {
  if (label.rays == 0) return;
  const auto width = static_cast<std::size_t>(camera.width), height = static_cast<std::size_t>(camera.height);
  bool is_own = false;
  std::uint32_t run = 0;
  for (std::size_t x = 0; x < width; ++x) {
    for (std::size_t y = 0; y < height; ++y) {
      if ((bodies[y * width + x] == label.actor + 1) != is_own) {
        label.mask_runs.push_back(run);
        run = 0;
        is_own = !is_own;
      }
      ++run;
      const Eigen::Vector2d corner(static_cast<double>(x), static_cast<double>(y));
      if (is_own) take_in(corner, corner + Eigen::Vector2d::Ones(), label.visible_px);
    }
  }
  label.mask_runs.push_back(run);
}

/// Share of the frame at which the sensor observes the middle of the actor's box; 1/2 when it does not.
double share_of_middle(const Sensor& sensor, const ActorBoxes& boxes, std::size_t actor) {
  const auto middle = [&](double share) -> Vector3d {
    return boxes.actor_from_sensor(actor, share).inverse().translation;
  };
  if (sensor.is_camera()) {
    const auto image = image_at_own_time(sensor.camera(), middle);
    return image ? image->share : 0.5;
  }
  const auto* const lidar = std::get_if<Lidar>(&sensor.lidar());
  double share = 0.5;
  for (int look = 0; lidar != nullptr && look < 4; ++look) {
    const std::optional<LidarHit> hit = locate(*lidar, middle(share));
    if (!hit) return 0.5;
    share = std::clamp(hit->time_fraction, 0.0, 1.0);
  }
  return share;
}

}  // namespace

LabelsOnDevice::LabelsOnDevice(const Device& device,
                               std::shared_ptr<const Scene> scene,
                               const RenderOptions& options)
    : scene_(std::move(scene)), alone_(device, without_background(*scene_), options) {}

std::vector<ActorLabel> LabelsOnDevice::of(const Frame& frame) {
  FrameAccess::need_of(frame, *scene_, "labels");
  const Sensor& sensor = frame.sensor();
  const Shot& shot = frame.shot();
  const bool is_camera = sensor.is_camera();
  const ActorBoxes boxes(scene_->actors,
                         view_of(*scene_, shot, is_camera ? SetKind::kCamera : SetKind::kLidar));
  const std::vector<std::uint32_t> bodies = bodies_in(frame);
  const auto rays_on = [](const std::vector<std::uint32_t>& all, std::size_t actor) {
    return static_cast<std::size_t>(std::count(all.begin(), all.end(), actor + 1));
  };
  std::vector<ActorLabel> out;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (!boxes.view().actors[i].is_there) continue;
    ActorLabel label;
    label.actor = i;
    label.size_m = scene_->actors[i].size_m;
    const double share = share_of_middle(sensor, boxes, i);
    label.time_s = shot.time_start_s + share * (shot.time_end_s - shot.time_start_s);
    label.sensor_from_actor = boxes.actor_from_sensor(i, share).inverse();
    label.rig_from_actor = sensor.rig_from_sensor() * label.sensor_from_actor;
    label.world_from_actor = shot.pose_at(share) * label.sensor_from_actor;
    label.rays = rays_on(bodies, i);
    if (is_camera) {
      project_box(sensor.camera(), boxes, label);
      add_mask(bodies, sensor.camera(), label);
    }
    out.push_back(std::move(label));
  }
  for (ActorLabel& label : out) {
    if (is_camera && !label.projected_px) continue;
    Shot by_itself = shot;
    for (const ActorLabel& other : out) {
      if (other.actor != label.actor)
        by_itself.edits.push_back({scene_->actors[other.actor].name, ActorEdit::Remove{}});
    }
    const Frame whole = alone_.render(sensor, by_itself, {.actors = true});
    const std::size_t rays = std::max(rays_on(bodies_in(whole), label.actor), label.rays);
    if (rays > 0) label.occlusion = 1.0 - static_cast<double>(label.rays) / static_cast<double>(rays);
  }
  return out;
}

}  // namespace simuli
