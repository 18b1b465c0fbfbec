#include "host/apps/cli/report/eval_tables.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host/apps/cli/base/provenance.hpp"
#include "host/core/base/one_line.hpp"

namespace simuli::cli {
namespace {

std::string range_text(std::size_t i) {
  constexpr auto& kFrom_m = RangeScores::kFrom_m;
  if (i + 1 == kFrom_m.size()) return fmt::format("{} m and beyond", kFrom_m[i]);
  return fmt::format("{} to {} m", kFrom_m[i], kFrom_m[i + 1]);
}

std::vector<std::string> score_cells(const std::string& name, const EvalScores& s) {
  return {name,
          fmt::format("{} + {}", s.images, s.sweeps),
          number_text(s.psnr_db, 2),
          number_text(s.psnr_corrected_db, 2),
          number_text(s.ssim, 4),
          number_text(s.flip, 4),
          number_text(100.0 * s.lidar.distance_median_m, 2),
          number_text(s.lidar.mean_rel_l2, 4),
          number_text(100.0 * s.lidar.raydrop_accuracy, 2),
          number_text(s.lidar.chamfer_m, 4),
          number_text(s.lidar.intensity_rmse, 4)};
}

TextTable table_of_scores(const char* title) {
  return {title,
          {{""},
           {"pictures + sweeps"},
           {"PSNR dB", Better::kHigher},
           {"corrected dB", Better::kHigher},
           {"SSIM", Better::kHigher},
           {"FLIP", Better::kLower},
           {"median cm", Better::kLower},
           {"rel. L2", Better::kLower},
           {"drop right %", Better::kHigher},
           {"Chamfer m", Better::kLower},
           {"intensity RMS", Better::kLower}},
          {}};
}

TextTable table_of_uses(const EvalReport& r) {
  TextTable table = table_of_scores("held-out frames");
  if (r.between) table.rows.push_back(score_cells("between training frames", *r.between));
  if (r.middle) table.rows.push_back(score_cells("in the middle of the path", *r.middle));
  if (r.beyond) table.rows.push_back(score_cells("at the end of the path", *r.beyond));
  if (r.sensor) table.rows.push_back(score_cells("of held-out sensors", *r.sensor));
  return table;
}

TextTable table_of_sensors(const EvalReport& r) {
  TextTable table = table_of_scores("by sensor");
  for (const auto& [sensor, scores] : r.by_sensor) table.rows.push_back(score_cells(sensor, scores));
  return table;
}

TextTable table_of_ranges(const EvalReport& r) {
  TextTable table{"by range",
                  {{""},
                   {"returns"},
                   {"median cm", Better::kLower},
                   {"mean cm", Better::kLower},
                   {"dropped %", Better::kLower},
                   {"returns of nothing", Better::kLower},
                   {"pixels with a return"},
                   {"PSNR dB", Better::kHigher}},
                  {}};
  for (std::size_t i = 0; i < r.ranges.size(); ++i) {
    const RangeScores& s = r.ranges[i];
    if (s.returns + s.returns_of_nothing + s.pixels == 0) continue;
    table.rows.push_back({range_text(i),
                          fmt::format("{}", s.returns),
                          number_text(100.0 * s.distance_median_m, 2),
                          number_text(100.0 * s.distance_mean_m, 1),
                          number_text(100.0 * s.share_dropped, 2),
                          fmt::format("{}", s.returns_of_nothing),
                          fmt::format("{}", s.pixels),
                          number_text(s.psnr_db, 2)});
  }
  return table;
}

TextTable table_of_kinds(const EvalReport& r) {
  TextTable table{"by kind of object",
                  {{""},
                   {"pixels"},
                   {"PSNR dB", Better::kHigher},
                   {"returns"},
                   {"median cm", Better::kLower},
                   {"returns that end there %", Better::kHigher}},
                  {}};
  for (const KindScores& s : r.kinds) {
    table.rows.push_back({s.kind.empty() ? "of no kind" : s.kind,
                          fmt::format("{}", s.pixels),
                          number_text(s.psnr_db, 2),
                          fmt::format("{}", s.returns),
                          number_text(100.0 * s.distance_median_m, 2),
                          number_text(100.0 * s.share_met, 2)});
  }
  return table;
}

Json json_of(const RangeScores& s, std::size_t i) {
  const bool last = i + 1 == RangeScores::kFrom_m.size();
  return {{"from_m", RangeScores::kFrom_m[i]},
          {"to_m", last ? Json() : Json(RangeScores::kFrom_m[i + 1])},
          {"returns", s.returns},
          {"distance_median_m", s.distance_median_m},
          {"distance_mean_m", s.distance_mean_m},
          {"share_dropped", s.share_dropped},
          {"returns_of_nothing", s.returns_of_nothing},
          {"pixels", s.pixels},
          {"psnr_db", s.psnr_db}};
}

Json json_of(const KindScores& s) {
  return {{"kind", s.kind},
          {"pixels", s.pixels},
          {"psnr_db", s.psnr_db},
          {"returns", s.returns},
          {"distance_median_m", s.distance_median_m},
          {"share_met", s.share_met}};
}

}  // namespace

std::vector<TextTable> eval_tables(const EvalReport& report) {
  std::vector<TextTable> tables;
  for (TextTable& table : std::vector{table_of_uses(report),
                                      table_of_sensors(report),
                                      table_of_ranges(report),
                                      table_of_kinds(report)}) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  }
  return tables;
}

std::string text_of(const TextTable& table) {
  std::vector<std::vector<std::string>> lines = table.rows;
  lines.insert(lines.begin(), std::vector<std::string>());
  for (const TextColumn& column : table.header) lines.front().push_back(column.name);
  lines.front().front() = table.title;
  for (auto& line : lines) {
    for (std::string& cell : line) cell = on_one_line(cell);
  }
  std::vector<std::size_t> widths(table.header.size(), 0);
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  std::string text;
  for (const auto& line : lines) {
    text += fmt::format("  {:<{}}", line.front(), widths.front());
    for (std::size_t c = 1; c < line.size(); ++c) text += fmt::format("  {:>{}}", line[c], widths[c]);
    text += '\n';
  }
  return text;
}

Json json_of(const EvalScores& s) {
  const SweepMetrics& l = s.lidar;
  Json ranges = Json::array(), kinds = Json::array();
  for (std::size_t i = 0; i < s.ranges.size(); ++i) ranges.push_back(json_of(s.ranges[i], i));
  for (const KindScores& kind : s.kinds) kinds.push_back(json_of(kind));
  return {{"psnr_db", s.psnr_db},
          {"ssim", s.ssim},
          {"flip", s.flip},
          {"psnr_corrected_db", s.psnr_corrected_db},
          {"distance_median_m", l.distance_median_m},
          {"distance_expected_median_m", s.distance_expected_median_m},
          {"share_own", s.share_own},
          {"medl2_m2", l.medl2_m2},
          {"mean_rel_l2", l.mean_rel_l2},
          {"intensity_rmse", l.intensity_rmse},
          {"raydrop_accuracy", l.raydrop_accuracy},
          {"raydrop_trivial", l.raydrop_trivial},
          {"drop_recall", l.drop_recall},
          {"drop_precision", l.drop_precision},
          {"chamfer_m2", l.chamfer_m2},
          {"chamfer_m", l.chamfer_m},
          {"actor_psnr_db", s.actor_psnr_db},
          {"actor_pixels", s.actor_pixels},
          {"actor_distance_median_m", s.actor_distance_median_m},
          {"actor_returns", s.actor_returns},
          {"actor_share_met", s.actor_share_met},
          {"images", s.images},
          {"sweeps", s.sweeps},
          {"sweeps_without_distance", s.sweeps_without_distance},
          {"sweeps_without_drops", s.sweeps_without_drops},
          {"sweeps_without_predicted_drops", s.sweeps_without_predicted_drops},
          {"sweeps_without_chamfer", s.sweeps_without_chamfer},
          {"ranges", ranges},
          {"kinds", kinds}};
}

Json json_of(const PictureScore& s) {
  return {{"index", s.index},
          {"sensor", s.sensor},
          {"time_s", s.time_s},
          {"psnr_db", s.psnr_db},
          {"ssim", s.ssim},
          {"flip", s.flip},
          {"psnr_corrected_db", s.psnr_corrected_db}};
}

Json json_of(const SweepScore& s) {
  const SweepMetrics& m = s.metrics;
  return {{"index", s.index},
          {"sensor", s.sensor},
          {"time_s", s.time_s},
          {"distance_median_m", m.distance_median_m},
          {"distance_expected_median_m", s.expected_median_m},
          {"share_own", s.share_own},
          {"mean_rel_l2", m.mean_rel_l2},
          {"intensity_rmse", m.intensity_rmse},
          {"raydrop_accuracy", m.raydrop_accuracy},
          {"chamfer_m", m.chamfer_m}};
}

}  // namespace simuli::cli
