#pragma once
// Ground-truth labels of an actor in one frame of a rendered sensor.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/core/base/pose.hpp"

namespace simuli {

/// A rectangle in a picture, px: pixel (0, 0) covers [0, 1] x [0, 1].
struct PixelBox {
  double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;
  bool operator==(const PixelBox&) const = default;
};

/// Label of an actor present in the frame. Frame::actors() defines its body.
struct ActorLabel {
  std::size_t actor = 0;  // index in Scene::actors
  double time_s = 0.0;  // time when the sensor observes the middle of the box; poses refer to it
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // length, width, height of the box
  Pose world_from_actor, rig_from_actor, sensor_from_actor;
  /// Number of rays that end at its body: pixels of a camera, returns of a LiDAR.
  std::size_t rays = 0;
  /// Share of the rays that would hit its body without other objects in this frame, but end elsewhere; no value
  /// when it would have no ray.
  std::optional<double> occlusion = {};

  // Cameras only.
  std::optional<PixelBox> projected_px = {};  // around the box, within the picture; none: it is not in it
  std::optional<PixelBox> visible_px = {};  // around the body's pixels; no value without any
  /// Share of the box's surface outside the picture, ignoring occlusion.
  double truncation = 0.0;
  /// The body's pixels as alternating run lengths (COCO): down the columns, from the left one on, first
  /// background, then body.
  std::vector<std::uint32_t> mask_runs = {};
};

}  // namespace simuli
