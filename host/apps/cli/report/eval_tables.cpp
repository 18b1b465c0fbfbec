#include "host/apps/cli/report/eval_tables.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <type_traits>
#include <utility>

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

/// Puts reports and scores into a JSON object; a number that is not finite is null.
struct JsonScores {
  Json out = Json::object();

  template <class Value>
  void operator()(const char* key, const Value& value) {
    out[key] = value;
  }
  template <class Scores>
  requires std::is_base_of_v<FrameScore, Scores> || std::is_same_v<KindScores, Scores>
  void operator()(const char* key, const std::vector<Scores>& all) {
    Json& list = out[key] = Json::array();
    for (const Scores& scores : all) list.push_back(of(scores));
  }
  void operator()(const char* key, const std::vector<RangeScores>& ranges) {
    Json& list = out[key] = Json::array();
    for (std::size_t i = 0; i < ranges.size(); ++i) list.push_back(of(ranges[i], i));
  }
  void operator()(const char* key, const std::optional<EvalScores>& scores) {
    out[key] = scores ? of(*scores) : Json();
  }
  void operator()(const char* key, const std::vector<std::pair<std::string, EvalScores>>& by_name) {
    Json& all = out[key] = Json::object();
    for (const auto& [name, scores] : by_name) all[name] = of(scores);
  }

  template <class Scores, class... Index>
  static Json of(const Scores& scores, Index... index) {
    JsonScores inner;
    visit_scores(scores, index..., inner);
    return std::move(inner.out);
  }
};

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

Json json_of(const EvalReport& report) {
  JsonScores scores;
  visit_report(report, scores);
  return std::move(scores.out);
}

}  // namespace simuli::cli
