#include "host/cli/report/tile_picture.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "host/cli/draw/canvas.hpp"
#include "host/cli/draw/pictures.hpp"

namespace simuli::cli {
namespace {

constexpr int kWidth = 1600;
constexpr int kLeft = 110, kRight = 160, kTop = 60, kPanel = 330, kGap = 100;
constexpr int kPanels = 3;
constexpr int kWindowTiles = 14;  // tile columns in which single rays can be told apart
constexpr Colour kPaper{1.0F, 1.0F, 1.0F}, kInk{0.15F, 0.15F, 0.18F}, kFaint{0.86F, 0.87F, 0.90F};
constexpr Colour kRay{0.13F, 0.30F, 0.62F}, kPale{0.62F, 0.70F, 0.84F}, kEdge{0.85F, 0.20F, 0.12F};

double degrees(double rad) { return rad * 180.0 / std::numbers::pi; }

/// A panel's frame: values in degrees to pixels.
struct Axes {
  int top;
  double x0, x1, y0, y1;
  [[nodiscard]] int x(double value) const {
    return kLeft + static_cast<int>(std::lround((value - x0) / (x1 - x0) * (kWidth - kLeft - kRight)));
  }
  [[nodiscard]] int y(double value) const {
    return top + static_cast<int>(std::lround((y1 - value) / (y1 - y0) * kPanel));
  }
};

/// A round step that gives up to `count` of them.
double round_step(double span, int count) {
  const double least = span / count;
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= least) return factor * decade;
  }
  return 10.0 * decade;
}

std::string label(double value, double step) {
  return fmt::format("{:.{}f}", value + 0.0, step < 0.095 ? 2 : step < 0.95 ? 1 : 0);
}

void draw_axes(Canvas& canvas, const Axes& a, const std::string& title) {
  canvas.text(kLeft, a.top - 24, title, kInk);
  const int bottom = a.top + kPanel;
  const double step_x = round_step(a.x1 - a.x0, 10), step_y = round_step(a.y1 - a.y0, 6);
  for (double value = std::ceil(a.x0 / step_x) * step_x; value <= a.x1 + 1e-9; value += step_x) {
    canvas.fill(a.x(value), a.top, a.x(value) + 1, bottom + 6, kFaint);
    const std::string text = label(value, step_x);
    canvas.text(
        a.x(value) - static_cast<int>(text.size()) * Canvas::kCharacterWidth / 2, bottom + 12, text, kInk);
  }
  for (double value = std::ceil(a.y0 / step_y) * step_y; value <= a.y1 + 1e-9; value += step_y) {
    canvas.fill(kLeft - 6, a.y(value), kWidth - kRight, a.y(value) + 1, kFaint);
    const std::string text = label(value, step_y);
    canvas.text(
        kLeft - 12 - static_cast<int>(text.size()) * Canvas::kCharacterWidth, a.y(value) - 7, text, kInk);
  }
  canvas.text(kWidth / 2 - 170, bottom + 36, "ANGLE FROM THE CUT (DEGREES)", kInk);
}

/// Of every slot with a ray: spin angle and elevation in degrees.
struct Dot {
  double x, y;
};
std::vector<Dot> dots_of(const RayGrid& grid) {
  std::vector<Dot> dots;
  const std::size_t slots = grid.frame.slots;
  for (std::size_t slot = 0; slot < slots; ++slot) {
    if (grid.ray_of_slot[slot] < 0) continue;
    const double up = static_cast<double>(grid.sensor_ray[2 * slots + slot]);
    dots.push_back(
        {degrees(static_cast<double>(grid.u[slot])), degrees(std::asin(std::clamp(up, -1.0, 1.0)))});
  }
  return dots;
}

/// Where tile columns begin, and where the last ends, in degrees.
std::vector<double> column_edges(const RayGrid& grid) {
  std::vector<double> edges;
  const double first = grid.model.tile_first, scale = grid.model.tile_scale;
  for (std::size_t bin = 0; bin < grid.column_of_bin.size(); ++bin) {
    if (bin > 0 && grid.column_of_bin[bin] == grid.column_of_bin[bin - 1]) continue;
    edges.push_back(degrees(first + static_cast<double>(bin) / scale));
  }
  edges.push_back(degrees(grid.model.tile_last));
  return edges;
}

/// Half-way between the beams of neighbouring tile rows, from top to bottom, in degrees.
std::vector<double> row_edges(const RayGrid& grid, double top, double bottom) {
  std::vector<double> edges{top};
  for (std::size_t ty = 1; ty + 1 < grid.tile_rows.size(); ++ty) {
    const std::size_t below = grid.tile_rows[ty];
    edges.push_back(
        degrees((grid.row_elevation[below - 1] + grid.row_elevation[grid.frame.rows + below]) / 2.0));
  }
  edges.push_back(bottom);
  return edges;
}

void draw_rays(Canvas& canvas, const Axes& a, const std::vector<Dot>& dots, const Colour& colour) {
  for (const Dot& dot : dots) {
    if (dot.x < a.x0 || dot.x > a.x1) continue;
    canvas.fill(a.x(dot.x) - 1, a.y(dot.y) - 1, a.x(dot.x) + 1, a.y(dot.y) + 1, colour);
  }
}

void draw_counts(Canvas& canvas,
                 const Axes& a,
                 const RayGrid& grid,
                 const std::vector<double>& columns,
                 const std::vector<double>& rows) {
  const std::vector<std::uint32_t> counts = rays_of_tiles(grid);
  const std::uint32_t most = *std::max_element(counts.begin(), counts.end());
  const auto colour = [&](std::uint32_t count) { return colour_at(static_cast<double>(count) / most); };
  for (std::size_t tile = 0; tile < counts.size(); ++tile) {
    if (counts[tile] == 0) continue;
    const std::size_t tx = tile % grid.frame.tiles_x, ty = tile / grid.frame.tiles_x;
    canvas.fill(
        a.x(columns[tx]), a.y(rows[ty]), a.x(columns[tx + 1]), a.y(rows[ty + 1]), colour(counts[tile]));
  }
  for (const double row : rows) canvas.fill(kLeft, a.y(row), kWidth - kRight, a.y(row) + 1, kPaper);
  const int left = kWidth - kRight + 24;
  for (int y = 0; y < kPanel; ++y) {
    const auto count =
        static_cast<std::uint32_t>(std::lround((1.0 - static_cast<double>(y) / kPanel) * most));
    canvas.fill(left, a.top + y, left + 26, a.top + y + 1, count == 0 ? kPaper : colour(count));
  }
  for (const std::uint32_t count : {0U, most / 2, most}) {
    const int y = a.top + kPanel - static_cast<int>(static_cast<std::int64_t>(kPanel) * count / most);
    canvas.fill(left, y, left + 32, y + 1, kInk);
    canvas.text(left + 38, y - 7, std::to_string(count), kInk);
  }
}

}  // namespace

std::vector<std::uint32_t> rays_of_tiles(const RayGrid& grid) {
  std::vector<std::uint32_t> counts(std::size_t{grid.frame.tiles_x} * grid.frame.tiles_y, 0);
  for (std::size_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
    if (grid.ray_of_slot[slot] >= 0) ++counts[slot / grid.frame.tile_rays];
  }
  return counts;
}

Image tile_picture(const RayGrid& grid, const std::string& title) {
  const std::vector<Dot> dots = dots_of(grid);
  const auto [low, high] =
      std::minmax_element(dots.begin(), dots.end(), [](const Dot& p, const Dot& q) { return p.y < q.y; });
  const double margin = std::max(0.04 * (high->y - low->y), 0.2);
  const double bottom = low->y - margin, top = high->y + margin;
  const std::vector<double> columns = column_edges(grid), rows = row_edges(grid, top, bottom);
  const std::size_t shown = std::min<std::size_t>(kWindowTiles, grid.frame.tiles_x);
  const std::size_t from = (grid.frame.tiles_x - shown) / 2;

  Canvas canvas(kWidth, kTop + kPanels * (kPanel + kGap), kPaper);
  canvas.text(kLeft, 10, title, kInk);
  Axes axes{kTop, columns[from], columns[from + shown], bottom, top};
  draw_axes(
      canvas,
      axes,
      fmt::format("BEAM PATTERN, {} OF {} TILE COLUMNS: ELEVATION (DEGREES)", shown, grid.frame.tiles_x));
  draw_rays(canvas, axes, dots, kRay);

  axes.top += kPanel + kGap;
  draw_axes(canvas,
            axes,
            fmt::format("{} X {} TILES: ELEVATION (DEGREES)", grid.frame.tiles_y, grid.frame.tiles_x));
  draw_rays(canvas, axes, dots, kPale);
  for (std::size_t tx = from; tx <= from + shown; ++tx)
    canvas.fill(axes.x(columns[tx]) - 1, axes.top, axes.x(columns[tx]) + 1, axes.top + kPanel, kEdge);
  for (const double row : rows)
    canvas.fill(axes.x(axes.x0), axes.y(row) - 1, axes.x(axes.x1), axes.y(row) + 1, kEdge);

  axes.top += kPanel + kGap;
  axes.x0 = columns.front();
  axes.x1 = columns.back();
  draw_axes(canvas, axes, "RAYS PER TILE: ELEVATION (DEGREES)");
  draw_counts(canvas, axes, grid, columns, rows);
  return canvas.image();
}

}  // namespace simuli::cli
