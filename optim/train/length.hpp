#pragma once
// How long a training goes on that decides so itself, by what its own frames say.
#include <cstddef>
#include <span>
#include <vector>

#include "optim/train/length_options.hpp"

namespace simuli {

/// Keeps the newest loss of each training frame: their mean is over all frames, whatever their order.
class TrainLength {
 public:
  /// `epoch`: iterations in which each training picture is looked at once; `images` and `sweeps` are the
  /// log's.
  TrainLength(const LengthOptions& options, std::size_t epoch, std::size_t images, std::size_t sweeps);

  /// Iterations of the first stage.
  [[nodiscard]] int first() const { return first_; }
  [[nodiscard]] int most() const { return options_.most; }
  /// What a picture or a sweep of the log was off by.
  void add_image(std::size_t index, double square) { squares_[index] = square; }
  void add_sweep(std::size_t index, double loss) { losses_[index] = loss; }
  /// Ends the stage of `iterations`. Iterations at the end of the next one; 0: that was the last.
  [[nodiscard]] int end_stage(int iterations);
  [[nodiscard]] const std::vector<LengthStage>& stages() const { return stages_; }
  /// All that decides what it says from now on.
  [[nodiscard]] std::vector<double> state() const;
  /// As another one of the same log had it; false, and nothing taken, for what is none.
  [[nodiscard]] bool set_state(std::span<const double> state);

 private:
  LengthOptions options_;
  int first_;
  std::vector<double> squares_, losses_;  // by index; NaN: not seen
  std::vector<LengthStage> stages_;
};

}  // namespace simuli
