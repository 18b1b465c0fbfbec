#include "host/apps/cli/draw/chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "host/apps/cli/draw/html_text.hpp"

namespace simuli {
namespace {

constexpr int kWidth = 420, kHeight = 240, kLeft = 56, kRight = 12, kTop = 14, kBottom = 34, kSteps = 5;
constexpr std::array<const char*, 6> kColours{
    "#2a78d6", "#d6612a", "#3a9a4a", "#9a4ab0", "#b08a1a", "#2aa0a8"};

struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// Returns 1, 2 or 5 times a power of ten: about `count` steps over `span`.
double nice_step(double span, int count) {
  const double raw = span / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw) return factor * power;
  }
  return 10.0 * power;
}

/// Returns "12.3" or "2052": three digits, and all digits before the decimal point.
std::string value_text(double value) {
  return std::abs(value) < 1000.0 ? fmt::format("{:.3g}", value) : fmt::format("{:.0f}", value);
}

/// Returns the range of most values: values within the middle eighty percent or not farther outside than its
/// width. All values if there are few.
Span span_of_most(std::vector<double> values) {
  constexpr std::size_t kFew = 8;
  Span all;
  for (const double value : values) all.include(value);
  if (values.size() < kFew) return all;
  std::sort(values.begin(), values.end());
  const double low = values[values.size() / 10], high = values[values.size() - 1 - values.size() / 10];
  constexpr double kLeast = 0.02;  // relative minimum width, for equal values
  const double width = std::max(high - low, kLeast * std::max(std::abs(low), std::abs(high)));
  Span most;
  for (const double value : values) {
    if (value >= low - width && value <= high + width) most.include(value);
  }
  return most;
}

/// A drawing with a vertical axis.
class Drawing {
 public:
  explicit Drawing(const Span& values) : y_(values) {
    if (!(y_.high > y_.low)) {  // a constant has a band around it
      const double around = std::max(std::abs(y_.high), 1.0) * 0.01;
      y_ = {y_.low - around, y_.high + around};
    }
    svg_ = fmt::format(R"(<svg width="{0}" height="{1}" viewBox="0 0 {0} {1}" role="img">)", kWidth, kHeight);
    const double step = nice_step(y_.high - y_.low, kSteps);
    for (double v = std::ceil(y_.low / step) * step; v <= y_.high; v += step) {
      line(kLeft, y(v), kWidth - kRight, y(v));
      text(kLeft - 6.0, y(v) + 4, "end", fmt::format("{:g}", std::abs(v) < 1e-9 * step ? 0.0 : v));
    }
  }
  [[nodiscard]] double y(double v) const {
    return kHeight - kBottom - (v - y_.low) / (y_.high - y_.low) * (kHeight - kTop - kBottom);
  }
  void line(double x0, double y0, double x1, double y1) {
    svg_ += fmt::format(
        R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke="currentColor" stroke-opacity=".2"/>)",
        x0,
        y0,
        x1,
        y1);
  }
  void text(double x, double y, const char* anchor, const std::string& what) {
    svg_ += fmt::format(
        R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>)", x, y, anchor, escaped_html(what));
  }
  void add(const std::string& shape) { svg_ += shape; }
  [[nodiscard]] std::string finish() && { return std::move(svg_) + "</svg>"; }

 private:
  Span y_;
  std::string svg_;
};

const char* colour_of(std::size_t series) { return kColours[series % kColours.size()]; }

}  // namespace

std::string curves_svg(const std::string& x_label, const std::vector<ChartSeries>& series) {
  constexpr std::size_t kMostMarks = 60;
  constexpr std::ptrdiff_t kMaxReported = 2;
  Span x;
  std::vector<double> values;
  std::size_t drawn = 0;
  for (const ChartSeries& s : series) {
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      if (!std::isfinite(s.y[i])) continue;
      x.include(s.x[i]);
      values.push_back(s.y[i]);
      ++drawn;
    }
  }
  if (drawn < 2 || !(x.high > x.low)) return {};
  constexpr double kMargin = 0.04;  // avoids cut markers
  const Span most = span_of_most(values);
  const auto distant =
      std::count_if(values.begin(), values.end(), [&](double v) { return v < most.low || v > most.high; });
  const double margin = kMargin * (most.high - most.low);
  const Span y{most.low - margin, most.high + margin};
  const auto px = [&](double v) {
    return kLeft + (v - x.low) / (x.high - x.low) * (kWidth - kLeft - kRight);
  };
  Drawing drawing(y);
  const double step = nice_step(x.high - x.low, kSteps);
  for (double v = std::ceil(x.low / step) * step; v <= x.high; v += step) {
    drawing.line(px(v), kTop, px(v), kHeight - kBottom);
    drawing.text(
        px(v), kHeight - kBottom + 14, "middle", fmt::format("{:g}", std::abs(v) < 1e-9 * step ? 0.0 : v));
  }
  drawing.text(0.5 * (kLeft + kWidth - kRight), kHeight - 4, "middle", x_label);
  for (std::size_t s = 0; s < series.size(); ++s) {
    std::string points, marks, beyond;
    for (std::size_t i = 0; i < series[s].x.size(); ++i) {
      if (!std::isfinite(series[s].y[i])) continue;
      const double value = series[s].y[i], at_x = px(series[s].x[i]);
      const bool is_above = value > most.high, is_beyond = is_above || value < most.low;
      const double at_y = is_above ? kTop : is_beyond ? kHeight - kBottom : drawing.y(value);
      points += fmt::format("{:.1f},{:.1f} ", at_x, at_y);
      if (is_beyond) {
        const double foot = at_y + (is_above ? 7.0 : -7.0);
        beyond += fmt::format(
            R"(<polygon points="{:.1f},{:.1f} {:.1f},{:.1f} {:.1f},{:.1f}" fill="{}"><title>{} {:.5g}: {:.5g}</title></polygon>)",
            at_x,
            at_y,
            at_x - 4.0,
            foot,
            at_x + 4.0,
            foot,
            colour_of(s),
            escaped_html(series[s].name),
            series[s].x[i],
            value);
        // Labels only few distant points; those of a distant start of a curve would overlap.
        if (distant <= kMaxReported) {
          drawing.text(at_x + 6.0, is_above ? at_y + 8.0 : at_y - 2.0, "start", value_text(value));
        }
        continue;
      }
      marks += fmt::format(
          R"(<circle cx="{:.1f}" cy="{:.1f}" r="2.5" fill="{}"><title>{} {:.5g}: {:.5g}</title></circle>)",
          at_x,
          at_y,
          colour_of(s),
          escaped_html(series[s].name),
          series[s].x[i],
          value);
    }
    drawing.add(fmt::format(
        R"(<polyline fill="none" stroke="{}" stroke-width="1.6" points="{}"/>)", colour_of(s), points));
    if (series[s].x.size() <= kMostMarks) drawing.add(marks);
    drawing.add(beyond);
  }
  return std::move(drawing).finish();
}

std::string bars_svg(const std::vector<std::string>& labels, const std::vector<ChartSeries>& series) {
  Span y;
  std::vector<double> values;
  for (const ChartSeries& s : series) {
    for (const double value : s.y) {
      if (std::isfinite(value)) y.include(value), values.push_back(value);
    }
  }
  if (!(y.high >= y.low)) return {};
  constexpr double kFar = 3.0;  // times the next value: cut off
  constexpr double kRoom = 1.25;
  std::sort(values.begin(), values.end());
  while (values.size() > 1 && values.back() > kFar * values[values.size() - 2]) values.pop_back();
  if (values.back() > 0.0 && values.back() < y.high) y.high = kRoom * values.back();
  constexpr double kHardlyDiffer = 0.5;  // relative to the maximum
  const bool from_zero = !(y.low > kHardlyDiffer * y.high);
  const double foot =
      from_zero ? std::min(0.0, y.low) : y.low - 0.3 * std::max(y.high - y.low, 0.05 * y.high);
  Drawing drawing({foot, y.high > foot ? y.high : foot + 1.0});
  const double place = static_cast<double>(kWidth - kLeft - kRight) / static_cast<double>(labels.size());
  const double width = 0.8 * place / static_cast<double>(series.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const double left = kLeft + place * (static_cast<double>(i) + 0.1);
    drawing.text(left + 0.4 * place, kHeight - kBottom + 14, "middle", labels[i]);
    for (std::size_t s = 0; s < series.size(); ++s) {
      const double value = series[s].y[i];
      if (!std::isfinite(value)) continue;
      const bool is_cut = value > y.high;
      const double top = is_cut ? kTop : drawing.y(value), bottom = drawing.y(foot),
                   x = left + width * static_cast<double>(s);
      drawing.add(fmt::format(
          R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}"><title>{} {}: {:.5g}</title></rect>)",
          x,
          std::min(top, bottom),
          0.94 * width,
          std::abs(bottom - top),
          colour_of(s),
          escaped_html(labels[i]),
          escaped_html(series[s].name),
          value));
      if (is_cut) {  // two strokes mark the cut
        for (const double below : {10.0, 15.0}) {
          drawing.add(fmt::format(R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" class="cut"/>)",
                                  x - 2.0,
                                  top + below + 3.0,
                                  x + 0.94 * width + 2.0,
                                  top + below - 3.0));
        }
      }
      drawing.text(x + 0.47 * width, top - 3, "middle", value_text(value));
    }
  }
  return std::move(drawing).finish();
}

std::string chart_legend(const std::vector<ChartSeries>& series) {
  std::string legend;
  for (std::size_t s = 0; s < series.size() && series.size() > 1; ++s) {
    legend += fmt::format(
        R"( <span style="color:{}">&#9632;</span>&nbsp;{})", colour_of(s), escaped_html(series[s].name));
  }
  return legend;
}

}  // namespace simuli
