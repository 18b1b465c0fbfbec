#include "optim/calibration/camera/camera_edges.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace simuli::calibration {
namespace {

constexpr double kLeastJump_m = 0.5;
constexpr double kLeastJump = 0.08;  // smallest range step relative to the foreground's range
/// Largest relative range step to the foreground's next return; otherwise it is a single stray point.
constexpr double kSameSurface = 0.03;  // of the range

class SweepGrid {
 public:
  SweepGrid(const Sweep& sweep, const LogLidar& lidar, double time_start_s, double time_end_s)
      : sweep_(sweep), lidar_(lidar), start_s_(time_start_s), span_s_(time_end_s - time_start_s) {}

  [[nodiscard]] std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(sweep_.rays.columns) +
           static_cast<std::size_t>(column);
  }
  [[nodiscard]] double range(int row, int column) const {
    const bool inside = row >= 0 && row < sweep_.rays.rows && column >= 0 && column < sweep_.rays.columns;
    return inside ? static_cast<double>(sweep_.range[index(row, column)]) : 0.0;
  }
  [[nodiscard]] double azimuth(int row, int column) const {
    return static_cast<double>(sweep_.rays.azimuth[index(row, column)]);
  }
  [[nodiscard]] double elevation(int row, int column) const {
    return static_cast<double>(sweep_.rays.elevation[index(row, column)]);
  }
  /// Returns the edge half-way from (row, column) to angles (azimuth, elevation). Extrapolates the surface
  /// linearly in 1 / range from its previous return `before`: along a wall at grazing incidence ranges grow by
  /// decimetres per ray.
  [[nodiscard]] DepthEdge rim(
      int row, int column, double before, double azimuth_out, double elevation_out) const {
    const double last = range(row, column);
    const double r = 1.0 / (1.5 / last - 0.5 / before);  // planes are linear in 1 / range over small angles
    const double turn = 0.5 * std::remainder(azimuth_out - azimuth(row, column), 2.0 * std::numbers::pi);
    const double lift = 0.5 * (elevation_out - elevation(row, column));
    const Eigen::Vector3d inside = Lidar::direction(azimuth(row, column), elevation(row, column));
    const Eigen::Vector3d middle =
        Lidar::direction(azimuth(row, column) + turn, elevation(row, column) + lift);
    DepthEdge edge;
    edge.p_rig =
        lidar_.rig_from_lidar * (ray_origin(lidar_.model, sweep_.rays, index(row, column)) + r * middle);
    edge.across = lidar_.rig_from_lidar.rotation * (middle - inside).normalized();
    edge.half_width = r * (middle - inside).norm();
    edge.time_s = start_s_ + static_cast<double>(sweep_.rays.time_fraction[index(row, column)]) * span_s_;
    return edge;
  }

 private:
  const Sweep& sweep_;
  const LogLidar& lidar_;
  double start_s_;
  double span_s_;
};

bool is_rim(double foreground, double next, double background, double farthest_m) {
  if (!(foreground > 0.0 && foreground <= farthest_m && next > 0.0 && background > 0.0)) return false;
  return background - foreground >= std::max(kLeastJump_m, kLeastJump * foreground) &&
         std::abs(next - foreground) <= kSameSurface * foreground;
}

}  // namespace

std::vector<DepthEdge> depth_edges(
    const Sweep& sweep, const LogLidar& lidar, double time_start_s, double time_end_s, double farthest_m) {
  const SweepGrid grid(sweep, lidar, time_start_s, time_end_s);
  const Lidar& model = lidar.with_rows();
  const double step = model.azimuth_span / model.columns;
  std::vector<DepthEdge> edges;
  for (int row = 0; row < sweep.rays.rows; ++row) {
    for (int column = 0; column < sweep.rays.columns; ++column) {
      const double range = grid.range(row, column);
      if (!(range > 0.0)) continue;
      for (const int side : {-1, 1}) {
        const double before = grid.range(row, column - side);
        if (!is_rim(range, before, grid.range(row, column + side), farthest_m)) continue;
        edges.push_back(
            grid.rim(row, column, before, grid.azimuth(row, column + side), grid.elevation(row, column)));
      }
      for (const int side : {-1, 1}) {
        // The spatial neighbour above or below: rows need not fire at the same azimuth.
        const auto beside = [&](int other) {
          if (other < 0 || other >= sweep.rays.rows) return -1;
          const double apart = model.rows[static_cast<std::size_t>(row)].azimuth_offset -
                               model.rows[static_cast<std::size_t>(other)].azimuth_offset;
          return column + static_cast<int>(std::lround(model.spin_sign() * apart / step));
        };
        const int out = beside(row + side);
        const double before = grid.range(row - side, beside(row - side));
        if (!is_rim(range, before, grid.range(row + side, out), farthest_m)) continue;
        edges.push_back(
            grid.rim(row, column, before, grid.azimuth(row, column), grid.elevation(row + side, out)));
      }
    }
  }
  return edges;
}

Eigen::Vector2d EdgeImage::gradient(const Eigen::Vector2d& pixel) const {
  // Central differences at the four surrounding pixels, bilinear in between. Pixel centres are at halves.
  const double x = pixel.x() - 0.5;
  const double y = pixel.y() - 0.5;
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  if (x0 < 1 || y0 < 1 || x0 + 2 >= picture_.width() || y0 + 2 >= picture_.height()) {
    return Eigen::Vector2d::Zero();
  }
  const auto at = [&](int px, int py) { return static_cast<double>(picture_.at(px, py)); };
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const double share = (i == 0 ? 1.0 - (x - x0) : x - x0) * (j == 0 ? 1.0 - (y - y0) : y - y0);
      const int px = x0 + i;
      const int py = y0 + j;
      sum += share * 0.5 * Eigen::Vector2d(at(px + 1, py) - at(px - 1, py), at(px, py + 1) - at(px, py - 1));
    }
  }
  return sum;
}

bool EdgeImage::find(const Eigen::Vector2d& pixel,
                     const Eigen::Vector2d& direction,
                     double reach_px,
                     double least_strength,
                     Edge& edge) const {
  constexpr double kStep_px = 0.5;
  constexpr double kAcross = 0.5;  // smallest cosine between the edge's normal and the direction
  const int steps = static_cast<int>(std::ceil(reach_px / kStep_px));
  const auto along = [&](int i) {
    return std::abs(gradient(pixel + i * kStep_px * direction).dot(direction));
  };
  double best = 0.0;
  double best_place = 0.0;
  double before = along(-steps - 1);
  double here = along(-steps);
  for (int i = -steps; i <= steps; ++i) {
    const double after = along(i + 1);
    const double weight = std::exp(-0.5 * std::pow(2.0 * i * kStep_px / reach_px, 2.0));
    if (here >= least_strength && here >= before && here > after && here * weight > best) {
      best = here * weight;
      const double bend = before - 2.0 * here + after;  // peak of the parabola through the three values
      best_place = (i + (bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0)) * kStep_px;
    }
    before = here;
    here = after;
  }
  if (!(best > 0.0)) return false;
  edge.pixel = pixel + best_place * direction;
  const Eigen::Vector2d slope = gradient(edge.pixel);
  edge.strength = slope.norm();
  if (!(edge.strength > 0.0)) return false;
  edge.normal = slope / edge.strength;
  return std::abs(edge.normal.dot(direction)) >= kAcross;
}

}  // namespace simuli::calibration
