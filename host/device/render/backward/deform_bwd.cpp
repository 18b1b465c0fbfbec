// Launcher of "kernels/deform_bwd.cl".
#include "host/device/render/backward/deform_bwd.hpp"

#include <utility>

#include "cl/shared/layout.h"

namespace simuli {
namespace {

constexpr std::uint32_t kChunks = DeformSizes::kChunks;
constexpr std::uint32_t kNone = 0xffffffffU;

BuildOptions deform_options(Precision precision) {
  BuildOptions options;
  return options.real(precision);
}

}  // namespace

DeformBackwardStage::DeformBackwardStage(const Device& device, Precision precision)
    : buffers_(device, precision),
      sums_(Program(device, "kernels/deform_bwd.cl", deform_options(precision)), "deform_node_sums"),
      means_(Program(device, "kernels/deform_bwd.cl", deform_options(precision)), "deform_means") {}

void DeformBackwardStage::run(const ShapesInFrame& shapes,
                              const ParticleBuffers& particles,
                              const FrameBuffers& made,
                              RealBuffer& param_grads) {
  actors_.clear();
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t actor = 0; actor < particles.actors; ++actor) {
    if (shapes.at[actor + 1] == kNone) continue;
    const double* const nodes = shapes.reals.data() + shapes.at[actor + 1] + SIM_D_NODES;
    const auto count = static_cast<std::uint32_t>(nodes[0] * nodes[1] * nodes[2]);
    for (std::uint32_t node = 0; node < count; ++node) {
      actors_.push_back(actor);
      numbers.push_back(node);
    }
  }
  if (actors_.empty()) return;
  buffers_.node_actor.assign(actors_);
  buffers_.node_number.assign(numbers);
  buffers_.partial.reserve(std::size_t{3} * kChunks * actors_.size());
  const auto nodes = static_cast<std::uint32_t>(actors_.size());
  const FrameConstants& constants = made.constants;
  const RealBuffer& read_grads = param_grads;
  sums_.run_over(std::size_t{nodes} * kChunks,
                 {{"nodes", nodes},
                  {"chunks", kChunks},
                  {"stride", particles.stride},
                  {"node_actor", std::as_const(buffers_.node_actor)},
                  {"node_number", std::as_const(buffers_.node_number)},
                  particles,
                  constants,
                  made.projected,
                  {"param_grads", read_grads},
                  {"partial", buffers_.partial}});
  const auto count = static_cast<std::uint32_t>(particles.actor_list.count());
  means_.run_over(count,
                  {{"count", count},
                   {"stride", particles.stride},
                   particles,
                   constants,
                   made.projected,
                   {"param_grads", param_grads}});
}

std::vector<DeformationGradient> DeformBackwardStage::gradients(const ShapesInFrame& shapes) const {
  std::vector<DeformationGradient> out(shapes.share.size());
  if (actors_.empty()) return out;
  const std::vector<double> partial = buffers_.partial.download_double();
  for (std::size_t node = 0; node < actors_.size(); ++node) {
    const std::uint32_t actor = actors_[node];
    for (std::size_t k = 0; k < 3; ++k) {
      double sum = 0.0;
      for (std::size_t chunk = 0; chunk < kChunks; ++chunk) sum += partial[(node * kChunks + chunk) * 3 + k];
      out[actor].start.push_back((1.0 - shapes.share[actor]) * sum);
      out[actor].end.push_back(shapes.share[actor] * sum);
    }
  }
  return out;
}

}  // namespace simuli
