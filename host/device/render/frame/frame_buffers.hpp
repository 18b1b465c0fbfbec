#pragma once
// Device buffers of a frame, grouped by the stage that writes them (host/device/render/frame/stages.hpp).
#include "cl/shared/cluster.h"
#include "cl/shared/layout.h"
#include "cl/shared/sensor_constants.h"
#include "host/device/render/device/buffer_table.hpp"

namespace simuli {

template <>
struct ClTypeName<shared::Footprint> {
  static constexpr std::string_view value = "Footprint";
};
template <>
struct ClTypeName<shared::SensorConstants<double>> {
  static constexpr std::string_view value = "SensorConstants";
};
template <>
struct ClTypeName<shared::ActorConstants<double>> {
  static constexpr std::string_view value = "ActorConstants";
};

/// Sizes of a frame: N particles, M of them visible, K tile-Gaussian pairs, S ray slots.
struct FrameSizes {
  std::uint64_t particles = 0;         // N
  std::uint64_t stride = 0;  // of parameter rows: N rounded up
  std::uint64_t actors = 0;  // actors with a pose of their own
  std::uint64_t deformed_stride = 0;  // `stride` with non-rigid actors, else 0
  std::uint64_t shape_reals = 0;  // of non-rigid actors
  std::uint64_t moving_particles = 0;  // N if actors move during the frame, else 0
  std::uint64_t visible = 0;           // M
  std::uint64_t pairs = 0;         // K
  std::uint64_t slots = 0;             // S
  std::uint64_t tiles = 0;
  std::uint64_t ray_rows = 3;  // rows of world_ray: directions, with origins 6, with times 7
  std::uint64_t outputs = SIM_OUTPUTS;  // rows of blended outputs; cameras have no drop logit
  std::uint64_t work_items = 0;  // of counting passes, or of blending
};

/// Constants of sensor and actors from the host, and data derived from them before projection.
struct FrameConstants : BufferTable<FrameSizes> {
  using BufferTable::BufferTable;
  Structs<shared::SensorConstants> sensor{*this, "sensor", [](const FrameSizes&) {
                                            return std::uint64_t{shared::kReals<shared::SensorConstants>};
                                          }};
  /// [1 + A]
  Structs<shared::ActorConstants> actors{*this, "actors", [](const FrameSizes& s) {
                                           return shared::kReals<shared::ActorConstants> * (1 + s.actors);
                                         }};
  /// [1 + A] index of a non-rigid actor's grid in deform_shapes, all ones for rigid actors; empty without
  /// non-rigid ones.
  Words deform_at{
      *this, "deform_at", [](const FrameSizes& s) { return s.deformed_stride > 0 ? 1 + s.actors : 0; }};
  /// Boxes and node offsets of these grids in this frame (cl/math/deform.h).
  Reals deform_shapes{*this, "deform_shapes", [](const FrameSizes& s) { return s.shape_reals; }};
  /// [3][stride] deformation offsets of actor particles.
  Reals deform_offset{*this, "deform_offset", [](const FrameSizes& s) { return 3 * s.deformed_stride; }};
};

/// Rays in the scene frame.
struct WorldRays : BufferTable<FrameSizes> {
  using BufferTable::BufferTable;
  Reals world_ray{
      *this, "world_ray", [](const FrameSizes& s) { return s.ray_rows * s.slots; }};  // [3|6|7][S]
};

/// Projected particles.
struct Projected : BufferTable<FrameSizes> {
  using BufferTable::BufferTable;
  /// [clusters] in frame order: 0 for culled clusters, whose particles projection does not process.
  Words live{
      *this, "live", [](const FrameSizes& s) { return (s.particles + SIM_CLUSTER - 1) / SIM_CLUSTER; }};
  Reals records{*this, "records", [](const FrameSizes& s) { return SIM_RECORD * s.particles; }};  // [N][16]
  /// [N][4] of particles with a moving actor.
  Reals motions{*this, "motions", [](const FrameSizes& s) { return SIM_MOTION * s.moving_particles; }};
  Array<shared::Footprint> footprints{*this, "footprints", [](const FrameSizes& s) { return s.particles; }};
  Words keys{*this, "keys", [](const FrameSizes& s) { return s.particles; }};  // range; all ones: culled
};

/// Tile lists.
struct Binned : BufferTable<FrameSizes> {
  using BufferTable::BufferTable;
  Words order{*this, "order", [](const FrameSizes& s) { return s.visible; }};  // sorted by range
  Words tile{*this, "tile", [](const FrameSizes& s) { return s.pairs; }};  // ascending
  Words payload{
      *this, "payload", [](const FrameSizes& s) { return s.pairs; }};  // of each tile: nearest first
  Words first{*this, "first", [](const FrameSizes& s) { return s.tiles + 1; }};  // first pair of each tile
  std::uint32_t visible = 0;                                                     // M
  std::uint32_t pairs = 0;                                                   // K
};

/// Temporary buffers of binning.
struct BinScratch : BufferTable<FrameSizes> {
  using BufferTable::BufferTable;
  Words visible_keys{*this, "visible_keys", [](const FrameSizes& s) { return s.visible; }};
  /// Visible particles of each chunk, then their pairs.
  Words counts{*this, "counts", [](const FrameSizes& s) { return 2 * s.work_items; }};
};

/// Blended outputs.
struct Blended : BufferTable<FrameSizes> {
  using BufferTable::BufferTable;
  Reals out{*this, "out", [](const FrameSizes& s) { return s.outputs * s.slots; }};  // [6|7][S]
  /// Vectors for which a window did not find the exact order: bits by work-item.
  Words inverted{*this, "inverted", [](const FrameSizes& s) { return s.work_items; }};
};

/// A camera's picture after the colour grid.
struct PictureBuffers : BufferTable<FrameSizes> {
  using BufferTable::BufferTable;
  Reals picture{*this, "picture", [](const FrameSizes& s) { return 3 * s.slots; }};  // [3][S]
};

/// All buffers that a frame writes; they grow and never shrink.
struct FrameBuffers {
  FrameBuffers(const Device& device, Precision precision)
      : constants(device, precision),
        rays(device, precision),
        projected(device, precision),
        binned(device, precision),
        blended(device, precision) {}
  FrameConstants constants;
  WorldRays rays;
  Projected projected;
  Binned binned;
  Blended blended;
};

}  // namespace simuli
