#pragma once
#include <compare>

#include "host/device/render/options/options.hpp"
#include "host/device/render/rays/ray_grid.hpp"
#include "host/device/runtime/build_options.hpp"

namespace simuli {

/// Properties of a frame in addition to its renderer's options.
struct FrameKind {
  SensorType sensor = SensorType::kCamera;
  LensKind lens = LensKind::kPinhole;  // of cameras
  int windshield = 0;  // as in RayGrid
  bool moving = false;                 // the pose changes during the frame
  bool origins = false;  // rays have individual origins: moving sensor or lever arms
  bool actors = false;                 // particles belong to actors
  bool actor_motion = false;  // actors move during the frame; implies `moving` and `origins`
  bool deform = false;  // some actor is not rigid; needs actors
  int sh_degree = 0;
  ShStorage sh_storage = ShStorage::kFull;
  bool median = false;
  bool actor_ids = false;  // the actor at the median distance in its place; needs actors, median
  bool culling = false;    // by the ray mask

  auto operator<=>(const FrameKind&) const = default;
};

/// Specialisation of kernels. Parts that a frame does not need are not compiled.
struct Variant {
  FrameKind frame;
  RenderOptions options;

  /// Returns the options of all kernels of a frame; each program uses the names in its text.
  [[nodiscard]] BuildOptions build_options() const;
};

}  // namespace simuli
