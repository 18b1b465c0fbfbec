#pragma once
// What a bench measured, as one HTML file.
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
/// The charts, then one table for each thing measured. Atomic; Error{kInput} when the file can't be written.
void write_report(const std::filesystem::path& file,
                  const std::string& title,
                  const std::vector<Row>& rows,
                  const std::vector<Chart>& charts = {});

/// A chart per sensor of what lies on the front: error over frame time, both as powers of ten.
[[nodiscard]] std::vector<Chart> front_charts(const std::vector<TradePoint>& points);

}  // namespace simuli::bench
