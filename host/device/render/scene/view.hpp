#pragma once
#include <array>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/shot.hpp"

namespace simuli {

/// One view of a sensor. The scene has the axes of the world and an origin of its own (Scene::origin).
struct View {
  Pose scene_from_sensor_start;
  Pose scene_from_sensor_end;
  std::array<float, 3> background{0.0F, 0.0F, 0.0F};
  std::vector<ActorView> actors{};                  // what particles belong to (owners_during)
  RayDrop::Parameters drop = RayDrop::of_logits();  // of a LiDAR
  bool camera_median = false;                       // of a camera: median distances, too
  bool actor_ids = false;  // who is at the median distances, instead of them; they are the first feature
};

/// What a sensor of that set sees from: the shot, relative to the scene's origin, before its background.
[[nodiscard]] View view_of(const Scene& scene, const Shot& shot, SetKind kind);

}  // namespace simuli
