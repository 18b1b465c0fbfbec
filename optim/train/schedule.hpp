#pragma once
// What decides, iteration by iteration, which frame is used and how far parameters may move. Everything
// here is a pure function of the seed and the iteration.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/core/base/allowed.hpp"
#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// A well mixed hash of a seed and two counters (splitmix64 finaliser): the generator is its counter, so
/// that any draw can be made again without the ones before it.
[[nodiscard]] std::uint64_t counter_hash(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter);

/// Frames in epochs: each is a new permutation of all frames.
class FrameOrder {
 public:
  /// `stream` parts the orders that share one seed.
  FrameOrder(std::vector<std::size_t> frames, std::uint64_t seed, std::uint64_t stream);
  [[nodiscard]] bool empty() const { return frames_.empty(); }
  [[nodiscard]] std::size_t size() const { return frames_.size(); }
  [[nodiscard]] const std::vector<std::size_t>& frames() const { return frames_; }  // in no epoch's order
  /// The frame of an iteration; iterations may be asked for in any order. There must be frames.
  [[nodiscard]] std::size_t at(std::uint64_t iteration);

 private:
  void shuffle(std::uint64_t epoch);

  std::vector<std::size_t> frames_;
  std::vector<std::size_t> shuffled_;
  std::uint64_t seed_;
  std::uint64_t stream_;
  std::uint64_t epoch_ = 0;
};

inline constexpr double kCoolDown = 0.2;  // of a training, at its end

/// Learning rates of the parameter groups, per step of Adam, at the start. All fall exponentially: to
/// mean_final_m, and to final_share of what they were. During the cool-down they also fall in proportion, to
/// last_share of that, and the noise of the last steps with them: street 31.77 -> 31.86 dB, 0052 28.24 -> 28.31
/// (400 and 300 iterations, the latter at quarter size). The defaults are the camera set's; what others gave is in
/// docs/DECISIONS.md.
struct LearningRates {
  double mean_m = 1e-2;  // of a particle of 2 cm (cl/kernels/adam.cl)
  double mean_final_m = 1e-4;
  double log_scale = 3e-2;
  double rotation = 5e-3;  // of quaternions
  double opacity = 0.1;    // of logits
  double sh = 3e-2;        // of degree 0
  double sh_rest = 4e-3;   // of the degrees above
  double final_share = 0.3;
  double last_share = 0.05;
};
template <class F>
constexpr void visit_fields(LearningRates& o, F&& field) {
  field.group("Camera set");
  field("camera.rate.sh",
        o.sh,
        at_least(0.0),
        "Learning rate of colours at the start. Less: steadier, for long trainings.");
  field.internal(o.mean_m);
  field.internal(o.mean_final_m);
  field.internal(o.log_scale);
  field.internal(o.rotation);
  field.internal(o.opacity);
  field.internal(o.sh_rest);
  field.internal(o.final_share);
  field.internal(o.last_share);
}

/// The rates of a training of so many iterations: scales move faster in one of fewer than 1500, by the cube root of
/// the ratio, 3 times at most. A particle's size is what short trainings get wrong. 200 iterations, quarter size: 0013
/// 23.27 -> 23.54 dB, 0052 27.12 -> 27.51, PandaSet (20 frames) 29.64 -> 30.69, street 29.62 -> 29.84.
[[nodiscard]] LearningRates paced(LearningRates rates, int iterations);

/// Adam's epsilon of each parameter row [param_rows(sh_degree)]: `colour_epsilon` of those that state colours, a tenth
/// of it of means (by their particle's deviation), else none. What is hardly shown stays where it is: what no picture saw
/// 2 and 3 m beside the street's path 15.6 -> 16.1, 14.7 -> 15.6 dB, for 0.03 dB on it and 0.05 on 0052.
[[nodiscard]] std::vector<double> row_epsilons(int sh_degree, double colour_epsilon);

/// The rate of each parameter row [param_rows(sh_degree)] at `progress` in [0, 1] of the training.
[[nodiscard]] std::vector<double> row_rates(const LearningRates& rates, int sh_degree, double progress);

}  // namespace simuli
