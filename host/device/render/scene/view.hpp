#pragma once
#include <array>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/shot.hpp"

namespace simuli {

/// A view of one sensor, in the scene frame: the world's axes and the origin Scene::origin.
struct View {
  Pose scene_from_sensor_start;
  Pose scene_from_sensor_end;
  std::array<float, 3> background{0.0F, 0.0F, 0.0F};
  std::vector<ActorView> actors{};  // owners of particles (owners_during)
  RayDrop::Parameters drop = RayDrop::of_logits();  // of a LiDAR
  bool camera_median = false;  // cameras: also median distances
  bool actor_ids = false;  // actors at the median distances, which become the first feature
};

/// Returns the view of a set's sensor during the shot, relative to the scene's origin, without background.
[[nodiscard]] View view_of(const Scene& scene, const Shot& shot, SetKind kind);

}  // namespace simuli
