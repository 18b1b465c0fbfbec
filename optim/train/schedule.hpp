#pragma once
// Schedules of frames and learning rates by iteration. All functions depend only on the seed and the iteration.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/core/base/allowed.hpp"
#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// Hashes a seed and two counters (splitmix64 finaliser). A counter-based generator can repeat any draw without
/// the draws before it.
[[nodiscard]] std::uint64_t counter_hash(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter);

/// Order of frames in epochs: each epoch is a new permutation of all frames.
class FrameOrder {
 public:
  /// `stream` separates orders with the same seed.
  FrameOrder(std::vector<std::size_t> frames, std::uint64_t seed, std::uint64_t stream);
  [[nodiscard]] bool empty() const { return frames_.empty(); }
  [[nodiscard]] std::size_t size() const { return frames_.size(); }
  [[nodiscard]] const std::vector<std::size_t>& frames() const { return frames_; }  // not permuted
  /// Returns the frame of an iteration; iterations may be queried in any order. There must be frames.
  [[nodiscard]] std::size_t at(std::uint64_t iteration);

 private:
  void shuffle(std::uint64_t epoch);

  std::vector<std::size_t> frames_;
  std::vector<std::size_t> shuffled_;
  std::uint64_t seed_;
  std::uint64_t stream_;
  std::uint64_t epoch_ = 0;
};

inline constexpr double kCoolDown = 0.2;  // share of the iterations at the end

/// Initial learning rates of the parameter groups per step of Adam. All decay exponentially: means to
/// mean_final_m, others to final_share of their initial rate. During the cool-down all rates also decay
/// linearly to last_share, which reduces the noise of the last steps. The defaults are the camera set's
/// (docs/DECISIONS.md, "Learning rates").
struct LearningRates {
  double mean_m = 1e-2;  // for a particle of 2 cm (cl/kernels/adam.cl)
  double mean_final_m = 1e-4;
  double log_scale = 3e-2;
  double rotation = 5e-3;  // of quaternions
  double opacity = 0.1;    // of logits
  double sh = 3e-2;        // of degree 0
  double sh_rest = 4e-3;   // of higher degrees
  double final_share = 0.3;
  double last_share = 0.05;
};
template <class F>
constexpr void visit_fields(LearningRates& o, F&& field) {
  field.group("Camera set");
  field("camera.rate.sh",
        o.sh,
        at_least(0.0),
        "Initial learning rate of colours. Less: more stable, for long trainings.");
  field.internal(o.mean_m);
  field.internal(o.mean_final_m);
  field.internal(o.log_scale);
  field.internal(o.rotation);
  field.internal(o.opacity);
  field.internal(o.sh_rest);
  field.internal(o.final_share);
  field.internal(o.last_share);
}

/// Returns the rates for a training of `iterations`: below 1500 iterations scales move faster by the cube root
/// of the ratio, at most 3 times, because sizes converge last in short trainings (docs/DECISIONS.md, "Learning
/// rates").
[[nodiscard]] LearningRates paced(LearningRates rates, int iterations);

/// Returns Adam's epsilon of each parameter row [param_rows(sh_degree)]: `colour_epsilon` for colours, a tenth
/// of it for means (relative to the particle's deviation), else 0. It holds particles that pictures hardly see
/// in place (docs/DECISIONS.md, "Learning rates").
[[nodiscard]] std::vector<double> row_epsilons(int sh_degree, double colour_epsilon);

/// Returns the rate of each parameter row [param_rows(sh_degree)] at `progress` in [0, 1] of the training.
[[nodiscard]] std::vector<double> row_rates(const LearningRates& rates, int sh_degree, double progress);

}  // namespace simuli
