#include "optim/complete/inpaint_rows.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace simuli {
namespace {

constexpr float kFarther = 1.3F;  // ratio of ranges from which on surfaces differ
constexpr int kEdge = 3;  // rays next to a gap that define the surface there
constexpr float kJoined = 1.5F;  // largest ratio of the ranges of two sides on one plane

/// The surface on one side of a gap.
struct Side {
  float column = 0.0F;
  float inverse_m = 0.0F;
  std::array<float, 3> features{};
};

/// A row of a frame; a closed row continues at its other end.
class Row {
 public:
  Row(const RayRows& frame, std::size_t row) : frame_(frame), first_(row * frame.columns) {}

  [[nodiscard]] std::optional<std::size_t> ray(std::ptrdiff_t column) const {
    const auto columns = static_cast<std::ptrdiff_t>(frame_.columns);
    if (frame_.closed) column = (column % columns + columns) % columns;
    if (column < 0 || column >= columns) return std::nullopt;
    return first_ + static_cast<std::size_t>(column);
  }
  [[nodiscard]] bool is_hole(std::ptrdiff_t column) const {
    const auto at = ray(column);
    return at && frame_.is_hole(*at);
  }
  [[nodiscard]] bool is_inside(std::ptrdiff_t column) const { return ray(column).has_value(); }
  /// Returns the surface at `column` in direction `step`; no value without one.
  [[nodiscard]] std::optional<Side> side(std::ptrdiff_t column, int step) const {
    std::optional<Side> farthest = edge(column, step);
    if (!farthest) return std::nullopt;
    for (std::size_t beyond = 1; beyond < frame_.around; ++beyond) {
      column += step;
      const std::optional<Side> next = edge(column, step);
      if (!next) break;
      if (kFarther * next->inverse_m < farthest->inverse_m) farthest = next;
    }
    return farthest;
  }

 private:
  /// Returns the mean of the rays from `column` on that hit one surface; no value with too few.
  [[nodiscard]] std::optional<Side> edge(std::ptrdiff_t column, int step) const {
    Side sum;
    sum.column = static_cast<float>(column + step * (kEdge / 2));
    for (int count = 0; count < kEdge; ++count, column += step) {
      const auto at = ray(column);
      if (!at || !(frame_.range_m[*at] > 0.0F && std::isfinite(frame_.range_m[*at]))) return std::nullopt;
      const float inverse_m = 1.0F / frame_.range_m[*at];
      sum.inverse_m += inverse_m / kEdge;
      for (std::size_t c = 0; c < 3; ++c) sum.features[c] += frame_.features[*at][c] / kEdge;
    }
    return sum;
  }

  const RayRows& frame_;
  std::size_t first_;
};

Side between(const Side& left, const Side& right, float share) {
  Side out;
  out.inverse_m = left.inverse_m + share * (right.inverse_m - left.inverse_m);
  for (std::size_t c = 0; c < 3; ++c) {
    out.features[c] = left.features[c] + share * (right.features[c] - left.features[c]);
  }
  return out;
}

/// Fills the gap in columns [first, end).
void fill(const Row& row, std::ptrdiff_t first, std::ptrdiff_t end, std::vector<FilledRay>& out) {
  const std::optional<Side> left = row.side(first - 1, -1), right = row.side(end, 1);
  if (!left && !right) return;
  const bool open_left = !left && row.is_inside(first - 1), open_right = !right && row.is_inside(end);
  const auto put = [&](std::ptrdiff_t column, const Side& is) {
    out.push_back({*row.ray(column), 1.0F / is.inverse_m, is.features});
  };
  for (std::ptrdiff_t column = first; column < end; ++column) {
    const float share = static_cast<float>(column - first) / static_cast<float>(end - first);
    if (left && right) {
      const auto [least, most] = std::minmax(left->inverse_m, right->inverse_m);
      if (most <= kJoined * least) {
        put(column,
            between(
                *left, *right, (static_cast<float>(column) - left->column) / (right->column - left->column)));
      } else {
        put(column, left->inverse_m < right->inverse_m ? *left : *right);
      }
    } else if (left && !(open_right && share >= 0.5F)) {
      put(column, *left);
    } else if (right && !(open_left && share < 0.5F)) {
      put(column, *right);
    }
  }
}

}  // namespace

std::vector<FilledRay> inpaint_rows(const RayRows& frame) {
  std::vector<FilledRay> out;
  const auto columns = static_cast<std::ptrdiff_t>(frame.columns);
  for (std::size_t r = 0; r < frame.rows; ++r) {
    const Row row(frame, r);
    std::ptrdiff_t column = 0;
    // A gap across the ends of a closed row is handled where it begins.
    while (frame.closed && column < columns && row.is_hole(column)) ++column;
    if (frame.closed && column == columns) continue;
    const std::ptrdiff_t end_of_row = frame.closed ? column + columns : columns;
    while (column < end_of_row) {
      if (!row.is_hole(column)) {
        ++column;
        continue;
      }
      std::ptrdiff_t end = column;
      while (end < end_of_row && row.is_hole(end)) ++end;
      fill(row, column, end, out);
      column = end;
    }
  }
  return out;
}

void widen_actors(RayRows& frame, int by) {
  const std::vector<std::uint32_t> before = frame.actor;
  const auto rows = static_cast<std::ptrdiff_t>(frame.rows),
             columns = static_cast<std::ptrdiff_t>(frame.columns);
  const auto widen = [&](std::ptrdiff_t y, std::ptrdiff_t x, std::uint32_t actor) {
    for (std::ptrdiff_t v = std::max<std::ptrdiff_t>(y - by, 0); v <= std::min(y + by, rows - 1); ++v) {
      for (std::ptrdiff_t u = x - by; u <= x + by; ++u) {
        if (!frame.closed && (u < 0 || u >= columns)) continue;
        std::uint32_t& there =
            frame.actor[static_cast<std::size_t>(v * columns + (u % columns + columns) % columns)];
        if (there == 0) there = actor;
      }
    }
  };
  for (std::ptrdiff_t y = 0; y < rows; ++y) {
    for (std::ptrdiff_t x = 0; x < columns; ++x) {
      const std::uint32_t actor = before[static_cast<std::size_t>(y * columns + x)];
      if (actor != 0) widen(y, x, actor);
    }
  }
}

}  // namespace simuli
