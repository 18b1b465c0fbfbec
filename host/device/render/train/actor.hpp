#pragma once
// Actors in training: pose gradients, and boxes that confine particles.
#include <Eigen/Core>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/device/render/backward/gradient_buffers.hpp"
#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

/// dL/d(pose) of an actor at a frame's start and end: by its position, and by a rotation vector about its
/// origin, both in scene axes.
struct ActorPoseGradient {
  Eigen::Vector3d shift_start = Eigen::Vector3d::Zero();
  Eigen::Vector3d revolution_start = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_end = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_end = Eigen::Vector3d::Zero();
};

struct ActorSizes {
  std::uint64_t actors = 0;

  static constexpr std::uint32_t kChunks = 64;  // chunks of each actor's list, summed in parallel
};
struct ActorBuffers : BufferTable<ActorSizes> {
  using BufferTable::BufferTable;
  /// [actors][chunks][2][SIM_POSE_GRAD]
  Reals partial{*this, "actor_sums", [](const ActorSizes& s) {
                  return s.actors * ActorSizes::kChunks * 2 * SIM_POSE_GRAD;
                }};
  Reals bounds{*this, "bounds", [](const ActorSizes& s) { return 4 * (s.actors + 1); }};
};

class ActorStage {
 public:
  ActorStage(const Device& device, Precision precision);
  /// Returns the pose gradients summed by actor over the particles that the frame did not cull. The order is
  /// fixed: the same frame gives the same bits. Waits.
  [[nodiscard]] std::vector<ActorPoseGradient> pose_gradients(const ParticleBuffers& particles,
                                                              const Projected& projected,
                                                              const GradientBuffers& gradients,
                                                              bool actor_motion);
  /// Moves means into the boxes of `actors`, enlarged by margin_m, and shortens particles whose standard
  /// deviation exceeds kLongest of the box's longest side.
  void confine(ParticleBuffers& particles, const std::vector<Actor>& actors, double margin_m);

  static constexpr double kLongest = 0.25;

 private:
  ActorBuffers buffers_;
  Kernel sums_, confine_;
};

}  // namespace simuli
