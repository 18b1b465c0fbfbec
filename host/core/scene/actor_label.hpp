#pragma once
// What is true of an actor in one frame of a sensor: labels of data that is rendered.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/core/base/pose.hpp"

namespace simuli {

/// Part of a picture, px: pixel (0, 0) covers [0, 1] x [0, 1].
struct PixelBox {
  double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;
  bool operator==(const PixelBox&) const = default;
};

/// An actor that is there. Its body is what Frame::actors() says.
struct ActorLabel {
  std::size_t actor = 0;  // place in Scene::actors
  double time_s = 0.0;    // when the sensor looked at the box's middle: poses are of then
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // length, width, height of the box
  Pose world_from_actor, rig_from_actor, sensor_from_actor;
  /// Rays that end at its body: pixels of a camera, returns of a LiDAR.
  std::size_t rays = 0;
  /// Share of its body's rays in this very frame, were it alone in the world, that end elsewhere; none: it
  /// would have no ray even then.
  std::optional<double> occlusion = {};

  // Of cameras alone.
  std::optional<PixelBox> projected_px = {};  // around the box, within the picture; none: it is not in it
  std::optional<PixelBox> visible_px = {};    // around the body's pixels; none: there are none
  /// Share of the box's surface that is not in the picture, hidden or not.
  double truncation = 0.0;
  /// The body's pixels: down the columns, from the left one on, how many in a row are not its own, are, are
  /// not, ... (COCO's run lengths).
  std::vector<std::uint32_t> mask_runs = {};
};

}  // namespace simuli
