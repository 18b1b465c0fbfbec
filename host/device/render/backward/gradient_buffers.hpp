#pragma once
// What a backward pass reads and writes beside the parts of its frame.
#include "host/device/render/frame/frame_buffers.hpp"

namespace simuli {

struct GradientSizes {
  FrameSizes frame;
  bool errors = false;         // of rays, shared out to pairs
  std::uint64_t replayed = 0;  // places of tile lists at a time, where rays have orders of their own
  std::uint64_t vectors = 0;   // of rays, likewise
};

struct GradientBuffers : BufferTable<GradientSizes> {
  using BufferTable::BufferTable;
  /// [5][S] of what blending wrote; from the losses.
  Reals grad_out{*this, "grad_out", [](const GradientSizes& s) { return 5 * s.frame.slots; }};
  /// [N]: where each particle's slots of grads and pair_error begin.
  Words slot_first{*this, "slot_first", [](const GradientSizes& s) { return s.frame.particles; }};
  /// [K][16] of the records, by pair: those of a particle together.
  Reals grads{*this, "grads", [](const GradientSizes& s) { return SIM_GRAD * s.frame.pairs; }};
  /// [S] and [K]: with errors.
  Reals ray_error{*this, "ray_error", [](const GradientSizes& s) { return s.errors ? s.frame.slots : 0; }};
  Reals pair_error{
      *this, "pair_error", [](const GradientSizes& s) { return s.errors ? s.frame.pairs : 0; }};
  /// [places][2][256] and [vectors]: what rays have blended in orders of their own.
  Reals replayed{*this, "replayed", [](const GradientSizes& s) { return 2 * SIM_TILE_RAYS * s.replayed; }};
  Words replayed_to{*this, "replayed_to", [](const GradientSizes& s) { return s.vectors; }};
  /// [6][stride] of the poses of particles' actors.
  Reals pose_grads{*this, "pose_grads", [](const GradientSizes& s) {
                     return s.frame.actors > 0 ? SIM_POSE_GRAD * s.frame.stride : 0;
                   }};
};

}  // namespace simuli
