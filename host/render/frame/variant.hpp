#pragma once
#include <compare>

#include "host/render/options/options.hpp"
#include "host/render/rays/ray_grid.hpp"
#include "host/runtime/build_options.hpp"

namespace simuli {

/// What kernels are specialised for. What a frame doesn't need compiles to nothing.
struct Variant {
  SensorType sensor = SensorType::kCamera;
  LensKind lens = LensKind::kPinhole;  // of a camera
  bool moving = false;                 // the pose changes during the frame
  bool origins = false;                // rays have origins of their own: moving, or lever arms
  bool actors = false;                 // particles belong to actors
  bool actor_motion = false;           // actors move during the frame: then `moving` and `origins`, too
  int sh_degree = 0;
  ShStorage sh_storage = ShStorage::kFull;
  bool median = false;
  Precision precision = Precision::kFloat;
  Projection projection = Projection::kUnscented;
  Extent extent = Extent::kUnscented;
  Order order = Order::kRange;
  ShDirection sh_direction = ShDirection::kParticle;
  Math math = Math::kFast;
  int shutter_iterations = 4;
  bool compensation = false;
  bool culling = false;  // by the ray mask
  LaneShape shape;

  [[nodiscard]] BuildOptions options() const;
  /// With the shape of a tile, for kernels of one work-group per tile.
  [[nodiscard]] BuildOptions tile_options() const;
  auto operator<=>(const Variant&) const = default;
};

}  // namespace simuli
