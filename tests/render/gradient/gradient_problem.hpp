#pragma once
// A loss with gradients from the backward pass and from differences of the forward pass.
#include <span>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/render/gradient/gradient_check.hpp"

namespace simuli::test {

/// Returns options with small cuts, so that no contribution appears or disappears by a parameter step.
inline RenderOptions smooth_options(Precision precision) {
  RenderOptions options = paper_options();
  options.precision = precision;
  options.alpha_cut = 1e-12;
  options.transmittance_cut = 0.0;
  return options;
}

/// L = sum of weight x output over the five outputs of all slots, as a function of the parameters.
class GradientProblem {
 public:
  GradientProblem(const Device& device,
                  const Shot& shot,
                  const GaussianSet& set,
                  const RenderOptions& options)
      : renderer_(device, options),
        rays_(shot.on(device, options)),
        view_(shot.view),
        particles_(device, set, options.precision),
        grads_(device, "parameter gradients", options.precision),
        base_(particles_.params.download_double()) {
    Random random(11);
    // Weights by ray, independent of slots; slots without a ray have weight 0.
    const RayGrid& grid = rays_.grid();
    for (int output = 0; output < 5; ++output) {
      std::vector<double> of_rays(grid.rays);
      for (double& w : of_rays) w = random.normal();
      for (const std::int32_t ray : grid.ray_of_slot)
        weights_.push_back(ray < 0 ? 0.0 : of_rays[static_cast<std::size_t>(ray)]);
    }
  }

  [[nodiscard]] std::size_t at(int row, int particle) const {
    return static_cast<std::size_t>(row) * particles_.stride + static_cast<std::size_t>(particle);
  }
  [[nodiscard]] const std::vector<double>& base() const { return base_; }
  [[nodiscard]] std::vector<double>& weights() { return weights_; }
  [[nodiscard]] std::size_t slots() const { return rays_.grid().frame.slots; }

  [[nodiscard]] std::vector<double> outputs_at(const std::vector<double>& params) {
    particles_.params.assign(std::span<const double>(params));
    return outputs(renderer_.render(particles_, rays_, view_));
  }
  [[nodiscard]] double loss_at(std::size_t parameter, double step) {
    std::vector<double> moved = base_;
    moved[parameter] += step;
    const std::vector<double> out = outputs_at(moved);
    double loss = 0.0;
    for (std::size_t i = 0; i < out.size(); ++i) loss += weights_[i] * out[i];
    return loss;
  }
  /// Returns the central difference, extrapolated once.
  [[nodiscard]] double quotient(std::size_t parameter, double h) {
    return extrapolated_quotient([&](double step) { return loss_at(parameter, step); }, h);
  }
  [[nodiscard]] std::vector<double> gradient() {
    particles_.params.assign(std::span<const double>(base_));
    Pass pass = renderer_.render(particles_, rays_, view_);
    pass.set_output_gradients(by_ray(pass.rays(), weights_));
    pass.backward(particles_, grads_);
    return grads_.download_double();
  }

 private:
  Renderer renderer_;
  SensorRays rays_;
  View view_;
  ParticleBuffers particles_;
  RealBuffer grads_;
  std::vector<double> base_, weights_;
};

}  // namespace simuli::test
