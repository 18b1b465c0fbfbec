#pragma once
// Charts as SVG: curves and bars.
#include <string>
#include <vector>

namespace simuli {

/// A curve of a chart. x and y have the same length; points with a non-finite y are omitted.
struct ChartSeries {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
};

/// Returns curves in one diagram; curves of few points have markers with values. The y axis covers most
/// points; distant points appear at its edge as triangles with their values. Empty if fewer than two points
/// are finite.
[[nodiscard]] std::string curves_svg(const std::string& x_label, const std::vector<ChartSeries>& series);

/// Returns bars of the series' y side by side at each of `labels`; x is ignored. The y axis starts at 0, or
/// slightly below the minimum if bars from 0 would hardly differ. A bar of more than three times the next is
/// cut off and labelled with its value. Empty if no value is finite.
[[nodiscard]] std::string bars_svg(const std::vector<std::string>& labels,
                                   const std::vector<ChartSeries>& series);

/// Returns the names of the series in their colours, as HTML; empty for one series.
[[nodiscard]] std::string chart_legend(const std::vector<ChartSeries>& series);

}  // namespace simuli
