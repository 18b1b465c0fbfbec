#pragma once
// Actors on the device: their poses during a frame, gradients of these, and the boxes that hold particles.
#include <Eigen/Core>
#include <vector>

#include "host/render/frame/stages.hpp"
#include "host/scene/actor.hpp"

namespace simuli {

/// The ActorConstants of a frame, as reals: one for the background, one per actor. centre_ref: o_ref of the
/// frame, scene frame. Fills `motion`: an actor that is there moves by more than a sensor at rest may
/// (frame_constants()).
[[nodiscard]] std::vector<double> actor_constants(const std::vector<ActorView>& actors,
                                                  const Eigen::Vector3d& centre_ref,
                                                  bool& motion);

/// dL/d(pose) of an actor at a frame's start and end: by its position, and by a rotation vector about its
/// origin, both in scene axes.
struct ActorPoseGradient {
  Eigen::Vector3d shift_start = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_start = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_end = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_end = Eigen::Vector3d::Zero();
};

class ActorStage {
 public:
  ActorStage(const Device& device, Precision precision);
  /// Sums of `buffers.pose_grads` over the particles that the frame did not cull, by actor. In one fixed
  /// order: the same frame gives the same bits. Waits.
  [[nodiscard]] std::vector<ActorPoseGradient> pose_gradients(const ParticleBuffers& particles,
                                                              const FrameBuffers& buffers,
                                                              bool actor_motion);
  /// Moves means into the boxes of `actors`, widened by margin_m to all sides, and shortens particles whose
  /// standard deviation is above kLongest of the box's longest side.
  void confine(ParticleBuffers& particles, const std::vector<Actor>& actors, double margin_m);

  static constexpr double kLongest = 0.25;

 private:
  RealBuffer partial_, bounds_;
  Kernel<std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         BufRealConst,
         BufRealConst,
         BufReal>
      sums_;
  Kernel<std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         BufRealConst,
         BufReal>
      confine_;
};

}  // namespace simuli
