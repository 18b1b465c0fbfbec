#pragma once
// What the scores of frames are made of: errors of single pixels and rays, pooled over frames.
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "optim/eval/eval_scores.hpp"

namespace simuli {

/// Pixels and returned rays that have something in common.
struct ErrorPool {
  std::size_t pixels = 0;
  double square = 0.0;          // of their errors, over pixels and three channels
  std::vector<float> errors_m;  // |d^ - d|, a value per return
  std::size_t met = 0;          // returns for which is_met() holds
  std::size_t dropped = 0;      // returns that the scene drops
  std::size_t returns_of_nothing = 0;

  void add(const ErrorPool& other);
  void add_pixel(double pixel_square) {
    ++pixels;
    square += pixel_square;
  }
  [[nodiscard]] double psnr_db() const;
  [[nodiscard]] double median_m() const;
  [[nodiscard]] double mean_m() const;
  /// `count` of the returns; NaN without any.
  [[nodiscard]] double share(std::size_t count) const;
};

/// The pools of one frame or of many: by range, and by kind of actor with the background behind.
struct ErrorPools {
  explicit ErrorPools(std::size_t kinds) : by_kind(kinds) {}
  void add(const ErrorPools& other);
  /// The pool of things `range_m` away.
  [[nodiscard]] ErrorPool& at(double range_m);

  std::array<ErrorPool, RangeScores::kFrom_m.size()> by_range;
  std::vector<ErrorPool> by_kind;
};

/// Mean of the values that are numbers.
class Mean {
 public:
  void add(double value);
  [[nodiscard]] double value() const;  // NaN of nothing
  [[nodiscard]] std::size_t left_out() const { return left_out_; }

 private:
  double sum_ = 0.0;
  std::size_t count_ = 0;
  std::size_t left_out_ = 0;
};

/// Sums over frames.
class ScoreSums {
 public:
  /// Kinds of actors; empty: the log has none that move.
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
