#pragma once
// Buffers of a backward pass in addition to the buffers of its frame.
#include "host/device/render/frame/frame_buffers.hpp"

namespace simuli {

struct GradientSizes {
  FrameSizes frame;
  bool errors = false;  // ray errors distributed to pairs
  std::uint64_t replayed = 0;  // list entries replayed at a time, for rays in their own order
  std::uint64_t vectors = 0;  // vectors of rays, likewise
};

struct GradientBuffers : BufferTable<GradientSizes> {
  using BufferTable::BufferTable;
  /// [5][S] gradients of the blended outputs, written by losses.
  Reals grad_out{*this, "grad_out", [](const GradientSizes& s) { return 5 * s.frame.slots; }};
  /// [N]: first gradient slot of each particle.
  Words slot_first{*this, "slot_first", [](const GradientSizes& s) { return s.frame.particles; }};
  /// [K][16] gradients of the records by pair, consecutive for each particle.
  Reals grads{*this, "grads", [](const GradientSizes& s) { return SIM_GRAD * s.frame.pairs; }};
  /// [S] and [K], with errors.
  Reals ray_error{*this, "ray_error", [](const GradientSizes& s) { return s.errors ? s.frame.slots : 0; }};
  Reals pair_error{
      *this, "pair_error", [](const GradientSizes& s) { return s.errors ? s.frame.pairs : 0; }};
  /// [places][2][256] and [vectors]: replay data of rays in their own order.
  Reals replayed{*this, "replayed", [](const GradientSizes& s) { return 2 * SIM_TILE_RAYS * s.replayed; }};
  Words replayed_to{*this, "replayed_to", [](const GradientSizes& s) { return s.vectors; }};
  /// [6][stride] gradients by the poses of the particles' actors.
  Reals pose_grads{*this, "pose_grads", [](const GradientSizes& s) {
                     return s.frame.actors > 0 ? SIM_POSE_GRAD * s.frame.stride : 0;
                   }};
};

}  // namespace simuli
