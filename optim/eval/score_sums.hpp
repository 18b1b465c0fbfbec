#pragma once
// Sums of scores: errors of pixels and rays, pooled over frames.
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "optim/eval/eval_scores.hpp"

namespace simuli {

/// A group of pixels and returned rays.
struct ErrorPool {
  std::size_t pixels = 0;
  double square = 0.0;  // sum of squared errors over pixels and three channels
  std::vector<float> errors_m;  // |d^ - d| of each return
  std::size_t met = 0;  // returns with is_met()
  std::size_t dropped = 0;  // returns that the scene drops
  std::size_t returns_of_nothing = 0;

  void add(const ErrorPool& other);
  void add_pixel(double pixel_square) {
    ++pixels;
    square += pixel_square;
  }
  [[nodiscard]] double psnr_db() const;
  [[nodiscard]] double median_m() const;
  [[nodiscard]] double mean_m() const;
  /// `count` as a share of the returns; NaN without any.
  [[nodiscard]] double share(std::size_t count) const;
};

/// Pools of one or many frames: by range, and by kind of actor, the background last.
struct ErrorPools {
  explicit ErrorPools(std::size_t kinds) : by_kind(kinds) {}
  void add(const ErrorPools& other);
  /// The pool of objects at distance `range_m`.
  [[nodiscard]] ErrorPool& at(double range_m);

  std::array<ErrorPool, RangeScores::kFrom_m.size()> by_range;
  std::vector<ErrorPool> by_kind;
};

/// Mean of finite values.
class Mean {
 public:
  void add(double value);
  [[nodiscard]] double value() const;  // NaN without values
  [[nodiscard]] std::size_t left_out() const { return left_out_; }

 private:
  double sum_ = 0.0;
  std::size_t count_ = 0;
  std::size_t left_out_ = 0;
};

/// Sums over frames.
class ScoreSums {
 public:
  /// Kinds of actors; empty if the log has no moving ones.
  explicit ScoreSums(std::vector<std::string> kinds);

  void add(const PictureScore& score, const ErrorPools& pools);
  void add(const SweepScore& score, const ErrorPools& pools);
  [[nodiscard]] EvalScores scores() const;

 private:
  static constexpr std::size_t kSweepMetrics = 10;

  std::vector<std::string> kinds_;
  std::size_t images_ = 0, sweeps_ = 0;
  Mean psnr_, ssim_, flip_, psnr_corrected_, expected_, own_;
  std::array<Mean, kSweepMetrics> sweep_means_;
  ErrorPools pools_;
};

}  // namespace simuli
