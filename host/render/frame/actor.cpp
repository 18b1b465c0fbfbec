// Launcher of "kernels/actor.cl".
#include "host/render/frame/actor.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host/base/error.hpp"

namespace simuli {
namespace {

constexpr std::size_t kLocalSize = 16;
constexpr std::uint32_t kChunks = 64;  // of each actor's list, summed side by side
constexpr std::size_t kBounds = 4;

BuildOptions actor_options(Precision precision) {
  BuildOptions options;
  return options.real(precision);
}

}  // namespace

std::vector<double> actor_constants(const std::vector<ActorView>& actors,
                                    const Eigen::Vector3d& centre_ref,
                                    bool& motion) {
  motion = false;
  std::vector<double> values;
  for (std::size_t i = 0; i <= actors.size(); ++i) {
    shared::ActorConstants<double> row{};
    const auto put = [](const Eigen::Vector3d& v, double* to) { std::copy_n(v.data(), 3, to); };
    for (int k = 0; k < 3; ++k) row.rotation[4 * k] = 1.0;
    row.turn_axis[0] = 1.0;
    row.there = i == 0 || actors[i - 1].is_there ? 1.0 : 0.0;
    if (i > 0 && actors[i - 1].is_there) {
      const Pose& a = actors[i - 1].scene_from_actor_start;
      const Pose& b = actors[i - 1].scene_from_actor_end;
      a.check(fmt::format("actor {}", i - 1));
      b.check(fmt::format("actor {}", i - 1));
      const Pose middle = interpolate(a, b, 0.5);
      put(middle.translation - centre_ref, row.centre);
      put(b.translation - a.translation, row.step);
      const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = middle.rotation.toRotationMatrix();
      std::copy_n(rotation.data(), 9, row.rotation);
      // By the shorter arc, as slerp takes it; the axis is the same in the scene at all times of the turn.
      Eigen::Quaterniond turn = b.rotation * a.rotation.conjugate();
      if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
      const double sine = turn.vec().norm();
      if (sine > 0.0) put(turn.vec() / sine, row.turn_axis);
      row.turn_angle = 2.0 * std::atan2(sine, turn.w());
      motion = motion || row.turn_angle > 1e-9 || (b.translation - a.translation).norm() > 1e-9;
    }
    const auto reals = shared::reals_of(row);
    values.insert(values.end(), reals.begin(), reals.end());
  }
  return values;
}

ActorStage::ActorStage(const Device& device, Precision precision)
    : partial_(device, "pose gradient sums", precision),
      bounds_(device, "actor boxes", precision),
      sums_(Program(device, "kernels/actor.cl", actor_options(precision)), "actor_pose_sums"),
      confine_(Program(device, "kernels/actor.cl", actor_options(precision)), "actor_confine") {}

std::vector<ActorPoseGradient> ActorStage::pose_gradients(const ParticleBuffers& particles,
                                                          const FrameBuffers& buffers,
                                                          bool actor_motion) {
  const std::size_t items = std::size_t{particles.actors} * kChunks;
  partial_.reserve(items * 2 * SIM_POSE_GRAD);
  sums_.launch(round_up(items, kLocalSize),
               kLocalSize,
               particles.actors,
               kChunks,
               particles.stride,
               actor_motion ? 1U : 0U,
               particles.actor_list,
               particles.actor_first,
               buffers.keys,
               buffers.motions,
               buffers.pose_grads,
               partial_);
  std::vector<ActorPoseGradient> out(particles.actors);
  const std::vector<double> partial = partial_.download_double();
  for (std::size_t item = 0; item < items; ++item) {
    ActorPoseGradient& sum = out[item / kChunks];
    Eigen::Vector3d* parts[] = {&sum.shift_start, &sum.turn_start, &sum.shift_end, &sum.turn_end};
    for (std::size_t k = 0; k < 4; ++k) {
      *parts[k] += Eigen::Map<const Eigen::Vector3d>(partial.data() + item * 2 * SIM_POSE_GRAD + 3 * k);
    }
  }
  return out;
}

void ActorStage::confine(ParticleBuffers& particles, const std::vector<Actor>& actors, double margin_m) {
  if (particles.actors > actors.size()) {
    throw Error(ErrorKind::kInternal, "confine: particles of more actors than there are");
  }
  std::vector<double> bounds((actors.size() + 1) * kBounds, 0.0);
  for (std::size_t i = 0; i < actors.size(); ++i) {
    double* row = bounds.data() + (i + 1) * kBounds;
    for (Eigen::Index k = 0; k < 3; ++k) row[k] = 0.5 * actors[i].size_m(k) + margin_m;
    row[3] = std::log(kLongest * actors[i].size_m.maxCoeff());
  }
  bounds_.assign(bounds);
  const auto count = static_cast<std::uint32_t>(particles.actor_list.count());
  confine_.launch(round_up(count, kLocalSize),
                  kLocalSize,
                  count,
                  particles.stride,
                  particles.actor_list,
                  particles.actor_of,
                  bounds_,
                  particles.params);
}

}  // namespace simuli
