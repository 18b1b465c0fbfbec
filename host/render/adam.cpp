// Launcher of "kernels/adam.cl".
#include <cmath>

#include "host/render/stages.hpp"

namespace simuli {
namespace {

constexpr double kBeta1 = 0.9;
constexpr double kBeta2 = 0.999;
constexpr double kEpsilon = 1e-15;  // gradients of means over many rays are tiny: epsilon must not damp them

constexpr std::size_t kLocalSize = 32;

BuildOptions adam_options(const Device& device, Precision precision) {
  BuildOptions options;
  return options.real(precision).define("V", LaneShape::of(device, precision).lanes);
}

}  // namespace

AdamStage::AdamStage(const Device& device, const ParticleBuffers& particles)
    : lanes_(LaneShape::of(device, particles.params.precision()).lanes),
      rate_(device, "Adam rates", particles.params.precision()),
      first_(device, "Adam first moment", particles.params.precision(), particles.params.count()),
      second_(device, "Adam second moment", particles.params.precision(), particles.params.count()),
      rejected_(device, "Adam rejected", std::vector<std::uint32_t>{0}),
      adam_(Program(device, "kernels/adam.cl", adam_options(device, particles.params.precision())), "adam") {
  first_.fill(0.0);
  second_.fill(0.0);
}

void AdamStage::run(ParticleBuffers& particles,
                    const RealBuffer& grads,
                    const Buffer<std::uint32_t>& keys,
                    const std::vector<double>& rate) {
  ++iteration_;
  rate_.assign(rate);
  const auto t = static_cast<double>(iteration_);
  const std::size_t items = particles.stride / static_cast<std::size_t>(lanes_);
  adam_.launch(round_up(items, kLocalSize),
               kLocalSize,
               particles.count,
               particles.stride,
               static_cast<std::uint32_t>(rate.size()),
               keys,
               rate_,
               kBeta1,
               kBeta2,
               1.0 / (1.0 - std::pow(kBeta1, t)),
               1.0 / (1.0 - std::pow(kBeta2, t)),
               kEpsilon,
               grads,
               first_,
               second_,
               particles.params,
               rejected_);
}

}  // namespace simuli
