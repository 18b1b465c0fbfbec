#include "optim/eval/score_sums.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace simuli {
namespace {

constexpr std::array kMetrics{&SweepMetrics::distance_median_m,
                              &SweepMetrics::medl2_m2,
                              &SweepMetrics::mean_rel_l2,
                              &SweepMetrics::intensity_rmse,
                              &SweepMetrics::raydrop_accuracy,
                              &SweepMetrics::raydrop_trivial,
                              &SweepMetrics::drop_recall,
                              &SweepMetrics::drop_precision,
                              &SweepMetrics::chamfer_m2,
                              &SweepMetrics::chamfer_m};

std::size_t left_out(const std::array<Mean, kMetrics.size()>& means, double SweepMetrics::*metric) {
  const auto found = std::find(kMetrics.begin(), kMetrics.end(), metric);
  return means[static_cast<std::size_t>(found - kMetrics.begin())].left_out();
}

RangeScores scores_of(const ErrorPool& pool) {
  RangeScores out;
  out.returns = pool.errors_m.size();
  out.distance_median_m = pool.median_m();
  out.distance_mean_m = pool.mean_m();
  out.share_dropped = pool.share(pool.dropped);
  out.returns_of_nothing = pool.returns_of_nothing;
  out.pixels = pool.pixels;
  out.psnr_db = pool.psnr_db();
  return out;
}

KindScores scores_of(const ErrorPool& pool, const std::string& kind) {
  return {kind, pool.pixels, pool.psnr_db(), pool.errors_m.size(), pool.median_m(), pool.share(pool.met)};
}

}  // namespace

void ErrorPool::add(const ErrorPool& other) {
  pixels += other.pixels;
  square += other.square;
  errors_m.insert(errors_m.end(), other.errors_m.begin(), other.errors_m.end());
  met += other.met;
  dropped += other.dropped;
  returns_of_nothing += other.returns_of_nothing;
}

double ErrorPool::psnr_db() const {
  return pixels > 0 ? -10.0 * std::log10(square / (3.0 * static_cast<double>(pixels))) : kNoNumber;
}

double ErrorPool::median_m() const {
  return errors_m.empty() ? kNoNumber : median(std::vector<double>(errors_m.begin(), errors_m.end()));
}

double ErrorPool::mean_m() const {
  if (errors_m.empty()) return kNoNumber;
  return std::accumulate(errors_m.begin(), errors_m.end(), 0.0) / static_cast<double>(errors_m.size());
}

double ErrorPool::share(std::size_t count) const {
  return errors_m.empty() ? kNoNumber : static_cast<double>(count) / static_cast<double>(errors_m.size());
}

void ErrorPools::add(const ErrorPools& other) {
  for (std::size_t i = 0; i < by_range.size(); ++i) by_range[i].add(other.by_range[i]);
  for (std::size_t i = 0; i < by_kind.size(); ++i) by_kind[i].add(other.by_kind[i]);
}

ErrorPool& ErrorPools::at(double range_m) {
  constexpr auto& kFrom_m = RangeScores::kFrom_m;
  const auto next = std::upper_bound(kFrom_m.begin() + 1, kFrom_m.end(), range_m);
  return by_range[static_cast<std::size_t>(next - kFrom_m.begin()) - 1];
}

void Mean::add(double value) {
  if (std::isnan(value)) {
    ++left_out_;
    return;
  }
  sum_ += value;
  ++count_;
}

double Mean::value() const { return count_ > 0 ? sum_ / static_cast<double>(count_) : kNoNumber; }

ScoreSums::ScoreSums(std::vector<std::string> kinds)
    : kinds_(std::move(kinds)), pools_(kinds_.empty() ? 0 : kinds_.size() + 1) {
  static_assert(kSweepMetrics == kMetrics.size());
}

void ScoreSums::add(const PictureScore& score, const ErrorPools& pools) {
  ++images_;
  psnr_.add(score.psnr_db);
  ssim_.add(score.ssim);
  flip_.add(score.flip);
  psnr_corrected_.add(score.psnr_corrected_db);
  pools_.add(pools);
}

void ScoreSums::add(const SweepScore& score, const ErrorPools& pools) {
  ++sweeps_;
  for (std::size_t m = 0; m < kMetrics.size(); ++m) sweep_means_[m].add(score.metrics.*kMetrics[m]);
  expected_.add(score.expected_median_m);
  own_.add(score.share_own);
  pools_.add(pools);
}

EvalScores ScoreSums::scores() const {
  EvalScores out;
  out.images = images_;
  out.sweeps = sweeps_;
  out.psnr_db = psnr_.value();
  out.ssim = ssim_.value();
  out.flip = flip_.value();
  out.psnr_corrected_db = psnr_corrected_.value();
  for (std::size_t m = 0; m < kMetrics.size(); ++m) out.lidar.*kMetrics[m] = sweep_means_[m].value();
  out.distance_expected_median_m = expected_.value();
  out.share_own = own_.value();
  out.sweeps_without_chamfer = left_out(sweep_means_, &SweepMetrics::chamfer_m);
  out.sweeps_without_distance = left_out(sweep_means_, &SweepMetrics::distance_median_m);
  out.sweeps_without_drops = left_out(sweep_means_, &SweepMetrics::drop_recall);
  out.sweeps_without_predicted_drops = left_out(sweep_means_, &SweepMetrics::drop_precision);
  for (const ErrorPool& pool : pools_.by_range) out.ranges.push_back(scores_of(pool));
  if (kinds_.empty()) return out;
  ErrorPool actors;
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    actors.add(pools_.by_kind[k]);
    out.kinds.push_back(scores_of(pools_.by_kind[k], kinds_[k]));
  }
  out.kinds.push_back(scores_of(pools_.by_kind.back(), KindScores::kBackground));
  out.actor_psnr_db = actors.psnr_db();
  out.actor_distance_median_m = actors.median_m();
  out.actor_share_met = actors.share(actors.met);
  out.actor_pixels = actors.pixels;
  out.actor_returns = actors.errors_m.size();
  return out;
}

}  // namespace simuli
