#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "host/apps/cli/report/report_parts.hpp"

namespace simuli::cli {
namespace {

/// Returns one curve per sensor, with one value per frame.
template <class Score, class Value>
std::vector<ChartSeries> by_sensor(const std::vector<Score>& scores, const Value& value) {
  std::vector<ChartSeries> series;
  for (const Score& score : scores) {
    auto found = std::find_if(
        series.begin(), series.end(), [&](const ChartSeries& s) { return s.name == score.sensor; });
    if (found == series.end()) found = series.insert(series.end(), {score.sensor, {}, {}});
    found->x.push_back(score.time_s);
    found->y.push_back(value(score));
  }
  return series;
}

void add_by_frame(HtmlReport& html, const EvalReport& report) {
  if (report.picture_scores.size() < 2 && report.sweep_scores.size() < 2) return;
  html.heading("Frame by frame");
  const char* const x = "s of the log";
  const auto pictures = [&](const char* title, const auto& value) {
    html.chart(title, x, by_sensor(report.picture_scores, value));
  };
  const auto sweeps = [&](const char* title, const auto& value) {
    html.chart(title, x, by_sensor(report.sweep_scores, value));
  };
  pictures("PSNR, dB", [](const PictureScore& s) { return s.psnr_db; });
  pictures("SSIM", [](const PictureScore& s) { return s.ssim; });
  sweeps("distance error, median, cm",
         [](const SweepScore& s) { return 100.0 * s.metrics.distance_median_m; });
  sweeps("ray-drop decisions right, %",
         [](const SweepScore& s) { return 100.0 * s.metrics.raydrop_accuracy; });
  sweeps("intensity error, RMS", [](const SweepScore& s) { return s.metrics.intensity_rmse; });
  sweeps("Chamfer distance, m", [](const SweepScore& s) { return s.metrics.chamfer_m; });
}

void add_by_range(HtmlReport& html, const EvalReport& report) {
  std::vector<std::string> labels;
  ChartSeries median{"median", {}, {}}, mean{"mean", {}, {}}, dropped{"dropped", {}, {}},
      psnr{"PSNR", {}, {}};
  for (std::size_t i = 0; i < report.ranges.size(); ++i) {
    const RangeScores& s = report.ranges[i];
    if (s.returns + s.pixels == 0) continue;
    const bool is_last = i + 1 == RangeScores::kFrom_m.size();
    labels.push_back(is_last
                         ? fmt::format("> {} m", RangeScores::kFrom_m[i])
                         : fmt::format("{} - {} m", RangeScores::kFrom_m[i], RangeScores::kFrom_m[i + 1]));
    median.y.push_back(100.0 * s.distance_median_m);
    mean.y.push_back(100.0 * s.distance_mean_m);
    dropped.y.push_back(100.0 * s.share_dropped);
    psnr.y.push_back(s.psnr_db);
  }
  if (labels.size() < 2) return;
  html.heading("By range");
  html.bars("distance error, median, cm", labels, {median});
  html.bars("distance error, mean, cm", labels, {mean});
  html.bars("recorded returns that the scene drops, %", labels, {dropped});
  html.bars("PSNR of pixels with a return, dB", labels, {psnr});
}

}  // namespace

void add_curves(HtmlReport& html, const EvalReport& report) {
  add_by_frame(html, report);
  add_by_range(html, report);
}

}  // namespace simuli::cli
