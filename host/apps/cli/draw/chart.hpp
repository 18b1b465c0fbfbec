#pragma once
// Diagrams as SVG: curves over an axis, and bars.
#include <string>
#include <vector>

namespace simuli {

/// A curve of a chart. x and y are of the same length; points whose y is not finite are left out.
struct ChartSeries {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
};

/// Curves over one axis; few points have marks that tell their values. The axis is that of most points: those
/// far outside stand at its edge, as triangles with their value. Empty when no series has two finite points.
[[nodiscard]] std::string curves_svg(const std::string& x_label, const std::vector<ChartSeries>& series);

/// Bars of the series' y beside each other at each of `labels`; their x is not looked at. From 0, or from a
/// little below the least where bars from 0 would hardly differ. One that is more than thrice the next is cut
/// off, with its value on it. Empty when nothing is finite.
[[nodiscard]] std::string bars_svg(const std::vector<std::string>& labels,
                                   const std::vector<ChartSeries>& series);

/// What the series are called, in their colours; empty for a single one. HTML.
[[nodiscard]] std::string chart_legend(const std::vector<ChartSeries>& series);

}  // namespace simuli
