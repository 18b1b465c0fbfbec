#pragma once
// HTML report of measurements.
#include <filesystem>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"
#include "bench/trade/trade.hpp"
#include "host/apps/cli/draw/chart.hpp"

namespace simuli::bench {

struct Chart {
  std::string title, x_label;
  std::vector<ChartSeries> series;
};
/// Writes the charts, then one table per measured subject, atomically. Throws Error{kInput} if the file
/// cannot be written.
void write_report(const std::filesystem::path& file,
                  const std::string& title,
                  const std::vector<Row>& rows,
                  const std::vector<Chart>& charts = {});

/// Returns a chart per sensor of the Pareto front: error over frame time, both as powers of ten.
[[nodiscard]] std::vector<Chart> front_charts(const std::vector<TradePoint>& points);

}  // namespace simuli::bench
