#pragma once
#include <compare>

#include "host/device/render/options/options.hpp"
#include "host/device/render/rays/ray_grid.hpp"
#include "host/device/runtime/build_options.hpp"

namespace simuli {

/// What a frame is, beside the options of its renderer.
struct FrameKind {
  SensorType sensor = SensorType::kCamera;
  LensKind lens = LensKind::kPinhole;  // of a camera
  int windshield = 0;                  // as in RayGrid
  bool moving = false;                 // the pose changes during the frame
  bool origins = false;                // rays have origins of their own: moving, or lever arms
  bool actors = false;                 // particles belong to actors
  bool actor_motion = false;           // actors move during the frame: then `moving` and `origins`, too
  bool deform = false;                 // some actor is not rigid; needs actors
  int sh_degree = 0;
  ShStorage sh_storage = ShStorage::kFull;
  bool median = false;
  bool actor_ids = false;  // the actor at the median distance instead of it; needs actors, median
  bool culling = false;    // by the ray mask

  auto operator<=>(const FrameKind&) const = default;
};

/// What kernels are specialised for. What a frame doesn't need compiles to nothing.
struct Variant {
  FrameKind frame;
  RenderOptions options;

  /// For all kernels of a frame: each takes those that its text names.
  [[nodiscard]] BuildOptions build_options() const;
};

}  // namespace simuli
