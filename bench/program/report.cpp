#include "bench/program/report.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <utility>

#include "host/apps/cli/draw/html_report.hpp"
#include "host/core/base/version.hpp"

namespace simuli::bench {

void write_report(const std::filesystem::path& file,
                  const std::string& title,
                  const std::vector<Row>& rows,
                  const std::vector<Chart>& charts) {
  HtmlReport html(title, std::string("simuli ") + version());
  for (const Chart& chart : charts) html.chart(chart.title, chart.x_label, chart.series);
  std::vector<std::vector<std::string>> cells;
  std::string table;
  const auto flush = [&] {
    if (cells.empty()) return;
    html.heading(table);
    html.table({"measured", "value", "unit", "+-"}, cells);
    cells.clear();
  };
  for (const Row& row : rows) {
    const std::string name = row.name.substr(0, row.name.rfind('/'));
    if (name != table) flush();
    table = name;
    cells.push_back({row.name.substr(std::min(row.name.size(), name.size() + 1)),
                     fmt::format("{:.5g}", row.value),
                     row.unit,
                     row.spread > 0.0 ? fmt::format("{:.2g}", row.spread) : ""});
  }
  flush();
  html.write(file);
}

std::vector<Chart> front_charts(const std::vector<TradePoint>& points) {
  std::map<std::string, std::map<double, double>> fronts;  // by sensor: error by frame time
  std::vector<Chart> charts;
  for (const TradePoint& p : points) {
    // The reference's error is 0, whose logarithm is undefined.
    if (p.on_front && p.error > 0.0) fronts[p.sensor][p.times_balanced.median] = p.error;
  }
  for (const auto& [sensor, front] : fronts) {
    ChartSeries line{"front", {}, {}};
    for (const auto& [times, error] : front) {
      line.x.push_back(std::log10(times));
      line.y.push_back(std::log10(error));
    }
    charts.push_back({sensor + ": log10 of the error (colours of 1, distances in m)",
                      "log10 of the frame's time, balanced is 0",
                      {std::move(line)}});
  }
  return charts;
}

}  // namespace simuli::bench
