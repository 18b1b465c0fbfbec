#include "bench/program/trade_picture.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>

#include "host/cli/draw/canvas.hpp"
#include "host/render/options/quality.hpp"

namespace simuli::bench {
namespace {

using cli::Canvas;
using cli::Colour;

constexpr int kLeft = 120, kPlot = 900, kList = 400, kTop = 56, kPanel = 560, kGap = 110, kBottom = 90;
constexpr int kWidth = kLeft + kPlot + kList;
constexpr Colour kPaper{1.0F, 1.0F, 1.0F}, kInk{0.15F, 0.15F, 0.18F}, kFaint{0.88F, 0.89F, 0.92F};
constexpr Colour kOption{0.45F, 0.55F, 0.75F}, kQuality{0.85F, 0.20F, 0.12F}, kFront{0.35F, 0.70F, 0.40F};

/// Decades, and what in them is labelled.
struct Scale {
  double low, high;  // base-10 logarithms
  static Scale of(const std::vector<double>& values) {
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const double margin = 0.06 * std::max(std::log10(*most / *least), 0.5);
    return {std::log10(*least) - margin, std::log10(*most) + margin};
  }
  [[nodiscard]] double place(double value) const { return (std::log10(value) - low) / (high - low); }
  [[nodiscard]] std::vector<double> ticks() const {
    std::vector<double> all;
    for (int decade = static_cast<int>(std::floor(low)); decade <= static_cast<int>(std::floor(high));
         ++decade) {
      for (const double factor : {1.0, 2.0, 5.0}) {
        const double value = factor * std::pow(10.0, decade);
        if (std::log10(value) >= low && std::log10(value) <= high) all.push_back(value);
      }
    }
    return all;
  }
};

struct Axes {
  int top;
  Scale time, error;
  [[nodiscard]] int x(double times) const {
    return kLeft + static_cast<int>(std::lround(time.place(times) * kPlot));
  }
  [[nodiscard]] int y(double value) const {
    return top + kPanel - static_cast<int>(std::lround(error.place(value) * kPanel));
  }
};

void dot(Canvas& canvas, int x, int y, int radius, const Colour& colour) {
  for (int dy = -radius; dy <= radius; ++dy) {
    const auto half =
        static_cast<int>(std::lround(std::sqrt(static_cast<double>(radius * radius - dy * dy))));
    canvas.fill(x - half, y + dy, x + half + 1, y + dy + 1, colour);
  }
}

void line(Canvas& canvas, int x0, int y0, int x1, int y1, const Colour& colour) {
  const int steps = std::max({std::abs(x1 - x0), std::abs(y1 - y0), 1});
  for (int i = 0; i <= steps; ++i) {
    const int x = x0 + (x1 - x0) * i / steps, y = y0 + (y1 - y0) * i / steps;
    canvas.fill(x - 1, y - 1, x + 2, y + 2, colour);
  }
}

void draw_axes(Canvas& canvas, const Axes& a, const TradePoint& any) {
  const char* unit = any.is_camera ? "RMS ERROR OF COLOURS (OF 1)" : "MEAN ERROR OF DISTANCES (MM)";
  canvas.text(kLeft, a.top - 30, fmt::format("{}: {} OVER TIME, BALANCED IS 1", any.sensor, unit), kInk);
  const int bottom = a.top + kPanel;
  for (const double times : a.time.ticks()) {
    canvas.fill(a.x(times), a.top, a.x(times) + 1, bottom + 6, kFaint);
    const std::string text = fmt::format("{:g}", times);
    canvas.text(
        a.x(times) - static_cast<int>(text.size()) * Canvas::kCharacterWidth / 2, bottom + 12, text, kInk);
  }
  for (const double error : a.error.ticks()) {
    canvas.fill(kLeft - 6, a.y(error), kLeft + kPlot, a.y(error) + 1, kFaint);
    const std::string text = fmt::format("{}", any.is_camera ? error : 1e3 * error);
    canvas.text(
        kLeft - 12 - static_cast<int>(text.size()) * Canvas::kCharacterWidth, a.y(error) - 7, text, kInk);
  }
}

void draw_panel(Canvas& canvas, int top, std::vector<TradePoint> points) {
  std::vector<double> times, errors;
  for (const TradePoint& p : points) {
    times.push_back(p.times_balanced.median);
    errors.push_back(p.error);
  }
  const Axes axes{top, Scale::of(times), Scale::of(errors)};
  draw_axes(canvas, axes, points.front());
  std::sort(points.begin(), points.end(), [](const TradePoint& a, const TradePoint& b) {
    return a.times_balanced.median < b.times_balanced.median;
  });
  const TradePoint* last = nullptr;
  for (const TradePoint& p : points) {
    // What lies within the noise of the front may be marked, too: the line only goes down.
    if (!p.on_front || (last != nullptr && p.error >= last->error)) continue;
    if (last != nullptr) {
      line(canvas,
           axes.x(last->times_balanced.median),
           axes.y(last->error),
           axes.x(p.times_balanced.median),
           axes.y(p.error),
           kFront);
    }
    last = &p;
  }
  int number = 0;
  for (const TradePoint& p : points) {
    const int x = axes.x(p.times_balanced.median), y = axes.y(p.error);
    if (p.is_quality) {
      dot(canvas, x, y, 8, kQuality);
      canvas.text(x + 14, y - 24, p.variant, kQuality);
      continue;
    }
    ++number;
    dot(canvas, x, y, 5, kOption);
    canvas.text(x + 7, y + 2, std::to_string(number), kInk);
    canvas.text(
        kLeft + kPlot + 24, top + 18 * (number - 1), fmt::format("{:>2} {}", number, p.variant), kInk);
  }
}

}  // namespace

Image trade_picture(const std::vector<TradePoint>& points) {
  std::vector<std::vector<TradePoint>> panels;
  for (const TradePoint& p : points) {
    if (panels.empty() || panels.back().front().sensor != p.sensor) panels.emplace_back();
    // The reference's error is 0 by definition: there is no place for it.
    if (p.error > 0.0) panels.back().push_back(p);
  }
  std::erase_if(panels, [](const auto& panel) { return panel.empty(); });
  const int count = static_cast<int>(panels.size());
  Canvas canvas(kWidth, kTop + count * kPanel + std::max(count - 1, 0) * kGap + kBottom, kPaper);
  for (int i = 0; i < count; ++i) {
    draw_panel(canvas, kTop + i * (kPanel + kGap), panels[static_cast<std::size_t>(i)]);
  }
  return canvas.image();
}

}  // namespace simuli::bench
