#include "host/device/render/outputs/flow.hpp"

#include <cstdint>

#include "host/core/base/error.hpp"
#include "host/core/base/parallel.hpp"
#include "host/core/sensors/own_time.hpp"
#include "host/device/render/scene/actor_boxes.hpp"
#include "host/device/render/scene/frame_state.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

constexpr double kSky_m = 1e6;

/// Position in the undeformed actor of the point that is at p (actor frame, m) at that share of the frame.
Vector3d at_rest(const ActorView& actor, double share, const Vector3d& p) {
  if (actor.deformation.empty()) return p;
  const DeformationView& shape = actor.deformation;
  const std::vector<double> offsets_m = shape.at(share);
  Vector3d rest = p;
  for (int look = 0; look < 5; ++look) rest = p - deformation_at(shape.nodes, shape.half_m, offsets_m, rest);
  return rest;
}

Vector3d deformed(const ActorView& actor, double share, const Vector3d& rest) {
  if (actor.deformation.empty()) return rest;
  const DeformationView& shape = actor.deformation;
  return rest + deformation_at(shape.nodes, shape.half_m, shape.at(share), rest);
}

}  // namespace

Flow flow_of(const Frame& frame, const Scene& scene, const Shot& to) {
  FrameAccess::need_of(frame, scene, "flow");
  const Camera& camera = frame.sensor().camera();
  const std::vector<float>& distances = frame.results().median;
  if (distances.empty()) {
    throw Error(ErrorKind::kUsage,
                "flow: found a frame without medians, allowed one rendered with FrameRequest::camera_median");
  }
  const std::vector<std::uint32_t> actors = frame.actors();
  const ActorBoxes now(scene.actors, view_of(scene, frame.shot(), SetKind::kCamera));
  const ActorBoxes then(scene.actors, view_of(scene, to, SetKind::kCamera));
  const RayGrid& grid = FrameAccess::grid(frame);
  const std::size_t slots = grid.frame.slots;
  Flow out{Image(camera.width, camera.height, 3), Image(camera.width, camera.height, 3)};
  const auto width = static_cast<std::size_t>(camera.width);
  parallel_each(slots, [&](std::size_t slot) {
    if (grid.ray_of_slot[slot] < 0) return;
    const auto ray = static_cast<std::size_t>(grid.ray_of_slot[slot]);
    const auto at = [&](std::size_t row) { return static_cast<double>(grid.sensor_ray[row * slots + slot]); };
    const double share = at(6);
    const bool is_sky = !(distances[ray] > 0.0F);
    const Vector3d p_camera =
        (is_sky ? kSky_m : static_cast<double>(distances[ray])) * Vector3d(at(0), at(1), at(2));
    Vector3d moved;
    std::optional<OwnTimeImage> image;
    const auto see = [&](const auto& p_then) { image = image_at_own_time(camera, p_then); };
    const std::size_t actor = actors[ray] - 1;  // unused without an actor
    if (actors[ray] != 0 && then.view().actors[actor].is_there) {
      const Vector3d rest =
          at_rest(now.view().actors[actor], share, now.actor_from_sensor(actor, share) * p_camera);
      see([&](double s) {
        moved = then.actor_from_sensor(actor, s).inverse() * deformed(then.view().actors[actor], s, rest);
        return moved;
      });
    } else if (actors[ray] == 0) {
      const Vector3d p_world = frame.shot().pose_at(share) * p_camera;
      see([&](double s) {
        moved = to.pose_at(s).inverse() * p_world;
        return moved;
      });
    }
    if (!image) return;
    const auto x = static_cast<int>(ray % width), y = static_cast<int>(ray / width);
    out.pixels.at(x, y, 0) = static_cast<float>(image->pixel.x() - (x + 0.5));
    out.pixels.at(x, y, 1) = static_cast<float>(image->pixel.y() - (y + 0.5));
    out.pixels.at(x, y, 2) = 1.0F;
    for (int k = 0; k < 3 && !is_sky; ++k) out.points.at(x, y, k) = static_cast<float>((moved - p_camera)[k]);
  });
  return out;
}

}  // namespace simuli
