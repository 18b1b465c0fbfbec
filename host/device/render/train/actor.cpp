// Launcher of "kernels/actor.cl".
#include "host/device/render/train/actor.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

constexpr std::uint32_t kChunks = ActorSizes::kChunks;
constexpr std::size_t kBounds = 4;

BuildOptions actor_options(Precision precision) {
  BuildOptions options;
  return options.real(precision);
}

}  // namespace

ActorStage::ActorStage(const Device& device, Precision precision)
    : buffers_(device, precision),
      sums_(Program(device, "kernels/actor.cl", actor_options(precision)), "actor_pose_sums"),
      confine_(Program(device, "kernels/actor.cl", actor_options(precision)), "actor_confine") {}

std::vector<ActorPoseGradient> ActorStage::pose_gradients(const ParticleBuffers& particles,
                                                          const Projected& projected,
                                                          const GradientBuffers& gradients,
                                                          bool actor_motion) {
  const std::size_t items = std::size_t{particles.actors} * kChunks;
  buffers_.reserve({particles.actors});
  sums_.run_over(items,
                 {{"actors", particles.actors},
                  {"chunks", kChunks},
                  {"stride", particles.stride},
                  {"moving", actor_motion ? 1U : 0U},
                  particles,
                  projected,
                  gradients,
                  {"partial", buffers_.partial}});
  std::vector<ActorPoseGradient> out(particles.actors);
  const std::vector<double> partial = buffers_.partial.download_double();
  for (std::size_t item = 0; item < items; ++item) {
    ActorPoseGradient& sum = out[item / kChunks];
    Eigen::Vector3d* parts[] = {&sum.shift_start, &sum.revolution_start, &sum.shift_end, &sum.turn_end};
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
  buffers_.bounds.assign(bounds);
  const auto count = static_cast<std::uint32_t>(particles.actor_list.count());
  confine_.run_over(count,
                    {{"count", count}, {"stride", particles.stride}, particles, {"bounds", buffers_.bounds}});
}

}  // namespace simuli
