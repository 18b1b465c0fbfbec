#pragma once
// Scores of a scene: means over frames, and errors by range and by kind of object.
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "host/core/base/fields.hpp"
#include "optim/base/metrics.hpp"

namespace simuli {

/// Value of scores without data.
inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// Scores of objects within a range interval from the sensor, over all frames.
struct RangeScores {
  /// Starts of the range intervals, m; each ends at the next start, the last is unbounded.
  static constexpr std::array kFrom_m{0.0, 10.0, 20.0, 40.0, 80.0};

  std::size_t returns = 0;               // recorded there
  double distance_median_m = kNoNumber;  // median of |d^ - d|
  double distance_mean_m = kNoNumber;
  double share_dropped = kNoNumber;    // share of these that the scene drops
  std::size_t returns_of_nothing = 0;  // rays without recorded return that return from there in the scene
  std::size_t pixels = 0;              // pixels with a recorded return at that distance from the camera
  double psnr_db = kNoNumber;          // of these pixels
};

/// Calls value(key, score) for each score of interval `i`, with the keys of all outputs. The last interval has an
/// infinite to_m.
template <class F>
constexpr void visit_scores(const RangeScores& s, std::size_t i, F&& value) {
  constexpr auto& kFrom_m = RangeScores::kFrom_m;
  value("from_m", kFrom_m.at(i));
  value("to_m", i + 1 < kFrom_m.size() ? kFrom_m.at(i + 1) : std::numeric_limits<double>::infinity());
  value("returns", s.returns);
  value("distance_median_m", s.distance_median_m);
  value("distance_mean_m", s.distance_mean_m);
  value("share_dropped", s.share_dropped);
  value("returns_of_nothing", s.returns_of_nothing);
  value("pixels", s.pixels);
  value("psnr_db", s.psnr_db);
}

/// Scores of actors of one kind, or of the background, over all frames.
struct KindScores {
  static constexpr const char* kBackground = "background";

  std::string kind;        // as in the log's actors, or kBackground
  std::size_t pixels = 0;  // whose first box is of that kind, or that see no box
  double psnr_db = kNoNumber;
  std::size_t returns = 0;  // in such a box, or in none
  double distance_median_m = kNoNumber;
  double share_met =
      kNoNumber;  // share of these rays that return from the same position in the scene (is_met())
};

template <class F>
constexpr void visit_scores(const KindScores& s, F&& value) {
  value("kind", s.kind);
  value("pixels", s.pixels);
  value("psnr_db", s.psnr_db);
  value("returns", s.returns);
  value("distance_median_m", s.distance_median_m);
  value("share_met", s.share_met);
}

/// Scores of one frame.
struct FrameScore {
  std::size_t index = 0;  // index into the log's pictures or sweeps
  std::string sensor;
  double time_s = 0.0;  // of its start
};
struct PictureScore : FrameScore {
  double psnr_db = kNoNumber;
  double ssim = kNoNumber;
  double flip = kNoNumber;
  double psnr_corrected_db = kNoNumber;
};
struct SweepScore : FrameScore {
  SweepMetrics metrics;  // of rays that hit the world
  double expected_median_m = kNoNumber;
  double share_own = kNoNumber;  // share of all fired rays that hit the ego vehicle
};

template <class F>
constexpr void visit_scores(const FrameScore& s, F&& value) {
  value("index", s.index);
  value("sensor", s.sensor);
  value("time_s", s.time_s);
}
template <class F>
constexpr void visit_scores(const PictureScore& s, F&& value) {
  visit_scores(static_cast<const FrameScore&>(s), value);
  value("psnr_db", s.psnr_db);
  value("ssim", s.ssim);
  value("flip", s.flip);
  value("psnr_corrected_db", s.psnr_corrected_db);
}
template <class F>
void visit_scores(const SweepScore& s, F&& value) {
  const SweepMetrics& m = s.metrics;
  visit_scores(static_cast<const FrameScore&>(s), value);
  value("distance_median_m", m.distance_median_m);
  value("distance_expected_median_m", s.expected_median_m);
  value("share_own", s.share_own);
  value("mean_rel_l2", m.mean_rel_l2);
  value("intensity_rmse", m.intensity_rmse);
  value("raydrop_accuracy", m.raydrop_accuracy);
  value("chamfer_m", m.chamfer_m);
}

/// Means over frames. NaN without such frames; sweeps with a NaN value (nothing predicted, nothing returned)
/// are left out of that mean and counted.
struct EvalScores {
  std::size_t images = 0;
  std::size_t sweeps = 0;
  double psnr_db = kNoNumber;
  double ssim = kNoNumber;
  double flip = kNoNumber;
  double psnr_corrected_db = kNoNumber;           // after the best affine colour transform of each picture
  SweepMetrics lidar;                             // of best_distance()
  double distance_expected_median_m = kNoNumber;  // the same median error with expected distances only
  double share_own = kNoNumber;  // share of rays that hit the ego vehicle, which are not compared
  /// Scores of the log's actors, NaN without any: PSNR of all pixels that see their boxes (pooled over
  /// pictures, whatever the scene shows there), median |d^ - d| of the returns inside, and the share of these
  /// rays that return from the same position in the scene (is_met()): for a removed actor this measures its
  /// ghost.
  double actor_psnr_db = kNoNumber;
  double actor_distance_median_m = kNoNumber;
  double actor_share_met = kNoNumber;
  std::size_t actor_pixels = 0;
  std::size_t actor_returns = 0;
  std::size_t sweeps_without_chamfer = 0;
  std::size_t sweeps_without_distance = 0;
  std::size_t sweeps_without_drops = 0;            // left out of the mean of recalls
  std::size_t sweeps_without_predicted_drops = 0;  // left out of the mean of precisions
  std::vector<RangeScores> ranges;                 // [RangeScores::kFrom_m]
  std::vector<KindScores>
      kinds;  // in the order of the log's moving actors, the background last; may be empty
};

/// Calls value(key, score) for each score; `ranges` and `kinds` are passed as vectors.
template <class F>
constexpr void visit_scores(const EvalScores& s, F&& value) {
  const SweepMetrics& l = s.lidar;
  value("psnr_db", s.psnr_db);
  value("ssim", s.ssim);
  value("flip", s.flip);
  value("psnr_corrected_db", s.psnr_corrected_db);
  value("distance_median_m", l.distance_median_m);
  value("distance_expected_median_m", s.distance_expected_median_m);
  value("share_own", s.share_own);
  value("medl2_m2", l.medl2_m2);
  value("mean_rel_l2", l.mean_rel_l2);
  value("intensity_rmse", l.intensity_rmse);
  value("raydrop_accuracy", l.raydrop_accuracy);
  value("raydrop_trivial", l.raydrop_trivial);
  value("drop_recall", l.drop_recall);
  value("drop_precision", l.drop_precision);
  value("chamfer_m2", l.chamfer_m2);
  value("chamfer_m", l.chamfer_m);
  value("actor_psnr_db", s.actor_psnr_db);
  value("actor_pixels", s.actor_pixels);
  value("actor_distance_median_m", s.actor_distance_median_m);
  value("actor_returns", s.actor_returns);
  value("actor_share_met", s.actor_share_met);
  value("images", s.images);
  value("sweeps", s.sweeps);
  value("sweeps_without_distance", s.sweeps_without_distance);
  value("sweeps_without_drops", s.sweeps_without_drops);
  value("sweeps_without_predicted_drops", s.sweeps_without_predicted_drops);
  value("sweeps_without_chamfer", s.sweeps_without_chamfer);
  value("ranges", s.ranges);
  value("kinds", s.kinds);
}

namespace detail {
template <class Scores, class... Index>
consteval std::size_t score_count(Index... index) {
  std::size_t count = 0;
  visit_scores(Scores{}, index..., [&count](const char* /*key*/, const auto& /*score*/) { ++count; });
  return count;
}
}  // namespace detail
static_assert(detail::score_count<RangeScores>(0U) ==
                  detail::member_count<RangeScores>() + 2,  // from_m, to_m
              "visit_scores() leaves out a member");
static_assert(detail::score_count<KindScores>() == detail::member_count<KindScores>(),
              "visit_scores() leaves out a member");
static_assert(detail::score_count<FrameScore>() == detail::member_count<FrameScore>(),
              "visit_scores() leaves out a member");
static_assert(detail::score_count<PictureScore>() ==
                  detail::member_count<PictureScore>() - 1 + detail::score_count<FrameScore>(),
              "visit_scores() leaves out a member");
static_assert(detail::score_count<EvalScores>() ==
                  detail::member_count<EvalScores>() - 1 + detail::member_count<SweepMetrics>(),
              "visit_scores() leaves out a member");

}  // namespace simuli
