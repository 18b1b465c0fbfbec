#pragma once
// Decides the length of an automatic training from the losses of its training frames.
#include <cstddef>
#include <span>
#include <vector>

#include "optim/train/length_options.hpp"

namespace simuli {

/// Stores the latest loss of each training frame: the mean is over all frames, whatever their order.
class TrainLength {
 public:
  /// `epoch`: iterations in which each training picture is used once; `images` and `sweeps`: counts in the log.
  TrainLength(const LengthOptions& options, std::size_t epoch, std::size_t images, std::size_t sweeps);

  /// Iterations of the first stage.
  [[nodiscard]] int first() const { return first_; }
  [[nodiscard]] int most() const { return options_.most; }
  /// Records the mean squared error of a picture or the loss of a sweep of the log.
  void add_image(std::size_t index, double square) { squares_[index] = square; }
  void add_sweep(std::size_t index, double loss) { losses_[index] = loss; }
  /// Ends the stage of `iterations`. Returns the last iteration of the next stage; 0: no further stage.
  [[nodiscard]] int end_stage(int iterations);
  [[nodiscard]] const std::vector<LengthStage>& stages() const { return stages_; }
  /// Returns all state that determines later decisions.
  [[nodiscard]] std::vector<double> state() const;
  /// Restores the state of an object for the same log; returns false and changes nothing for other data.
  [[nodiscard]] bool set_state(std::span<const double> state);

 private:
  LengthOptions options_;
  int first_;
  std::vector<double> squares_, losses_;  // by index; NaN: not seen yet
  std::vector<LengthStage> stages_;
};

}  // namespace simuli
