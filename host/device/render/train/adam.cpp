// Launcher of "kernels/adam.cl".
#include "host/device/render/train/adam.hpp"

#include <cmath>

#include "host/core/base/error.hpp"
#include "host/device/render/options/lane_shape.hpp"

namespace simuli {
namespace {

// Successive frames see different particles from different viewpoints, so long momentum is stale
// (docs/DECISIONS.md, "Learning rates").
constexpr double kBeta1 = 0.7;
constexpr double kBeta2 = 0.999;

}  // namespace

AdamStage::AdamStage(const Device& device, const ParticleBuffers& particles)
    : AdamStage(device, particles.params.precision(), particles.params.count()) {}

AdamStage::AdamStage(const Device& device, Precision precision, std::size_t parameters)
    : lanes_(lane_shape_of(device, precision).lanes),
      buffers_(device, precision),
      adam_(Program(device, "kernels/adam.cl", lane_options(device, precision)), "adam") {
  buffers_.reserve({parameters, 1});
  buffers_.first_moment.fill(0.0);
  buffers_.second_moment.fill(0.0);
  buffers_.rejected.fill(0);
}

void AdamStage::run(ParticleBuffers& particles,
                    const RealBuffer& grads,
                    const Buffer<std::uint32_t>& keys,
                    const AdamRows& rows) {
  ++iteration_;
  const Matrix all{particles.count, particles.stride, 0, false};
  launch(all, keys, rows, iteration_, grads, particles.params);
}

void AdamStage::run_dense(RealBuffer& params,
                          const RealBuffer& grads,
                          std::size_t first,
                          std::size_t count,
                          double rate,
                          std::uint64_t step,
                          double epsilon) {
  if (count % kStep != 0 || count > grads.count() || first + count > params.count() ||
      params.count() != buffers_.first_moment.count()) {
    throw Error(ErrorKind::kInternal, "Adam: gradients for other parameters");
  }
  const auto columns = static_cast<std::uint32_t>(count);
  launch({columns, columns, static_cast<std::uint32_t>(first), true},
         buffers_.rejected,
         {{rate}, {epsilon}},
         step,
         grads,
         params);
}

void AdamStage::launch(const Matrix& matrix,
                       const Buffer<std::uint32_t>& keys,
                       const AdamRows& rows,
                       std::uint64_t step,
                       const RealBuffer& grads,
                       RealBuffer& params) {
  const std::size_t count = rows.rate.size();
  buffers_.rate.assign(rows.rate);
  buffers_.epsilon.assign(rows.epsilon.empty() ? std::vector<double>(count, kAdamEpsilon) : rows.epsilon);
  const auto t = static_cast<double>(step);
  const std::size_t items = matrix.stride / static_cast<std::size_t>(lanes_);
  adam_.run_over(items,
                 {{"particles", matrix.columns},
                  {"stride", matrix.stride},
                  {"rows", static_cast<std::uint32_t>(count)},
                  {"dense", matrix.dense ? 1U : 0U},
                  {"first", matrix.first},
                  {"keys", keys},
                  {"beta1", kBeta1},
                  {"beta2", kBeta2},
                  {"inv_bias1", 1.0 / (1.0 - std::pow(kBeta1, t))},
                  {"inv_bias2", 1.0 / (1.0 - std::pow(kBeta2, t))},
                  {"grads", grads},
                  {"params", params},
                  buffers_});
}

}  // namespace simuli
