#include "optim/init/walls_upward.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <variant>

#include "host/core/base/parallel.hpp"
#include "io/log/frame_files.hpp"
#include "optim/init/initialize_sets.hpp"

namespace simuli {
namespace {

constexpr double kNearestWall_m = 1.0;  // from the sensor
/// A beam passes a position within this distance, or half the distance to the next beam.
constexpr double kBesideBeam_m = 0.15;
/// A ray ends at a position when their ranges differ by at most this, or this share of the range.
constexpr double kWallMargin_m = 0.3;
constexpr double kWallMarginShare = 0.02;
constexpr int kRounds = 3;  // iterations for the firing time and its direction

/// The rays of one sweep, by the positions that they pass.
class PassingRays {
 public:
  PassingRays(const PosedSweep& posed, const Lidar& lidar) : posed_(posed), lidar_(lidar) {
    for (const LidarRow& row : lidar.rows) slopes_.push_back(std::tan(row.elevation));
  }

  /// Whether all three neighbouring rays that pass a position continue behind it or do not return.
  [[nodiscard]] bool go_on_at(const Eigen::Vector3d& place) const {
    Eigen::Vector3d p;
    double share = 0.5;  // share of the sweep's time
    for (int round = 0; round < kRounds; ++round) {
      p = interpolate(posed_.scene_from_lidar_start, posed_.scene_from_lidar_end, share).inverse() * place;
      share = (column(p, 0.0) + 0.5) / lidar_.columns;
    }
    const double across_m = p.head<2>().norm();
    if (!(across_m > kNearestWall_m)) return false;
    const std::size_t row = nearest_row(across_m, p.z());
    if (row == lidar_.rows.size()) return false;
    const double range_m = std::hypot(across_m, p.z() - lidar_.rows[row].vertical_offset);
    const double margin_m = std::max(kWallMargin_m, kWallMarginShare * range_m);
    const int middle = column(p, lidar_.rows[row].azimuth_offset);
    for (const int beside : {-1, 0, 1}) {
      const int at = (middle + beside + lidar_.columns) % lidar_.columns;
      const std::size_t i = row * static_cast<std::size_t>(lidar_.columns) + static_cast<std::size_t>(at);
      if (!fires(lidar_, i)) continue;
      const auto ray_m = static_cast<double>(posed_.sweep.range[i]);
      if (ray_m > 0.0 ? ray_m < range_m + margin_m : is_blind(posed_.lidar, posed_.sweep.rays, i)) {
        return false;
      }
    }
    return true;
  }

 private:
  /// Nearest column; directions outside of a partial revolution map to its end.
  [[nodiscard]] int column(const Eigen::Vector3d& p, double offset) const {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    double angle = lidar_.spin_sign() * (std::atan2(p.y(), p.x()) - offset - lidar_.azimuth_first);
    angle -= kTurn * std::floor(angle / kTurn);
    const double at = std::round(angle / lidar_.azimuth_span * lidar_.columns);
    return static_cast<int>(std::min<double>(at, lidar_.columns - 1));
  }
  /// Row whose beam passes height z at across_m from the axis; rows.size() without one.
  [[nodiscard]] std::size_t nearest_row(double across_m, double z) const {
    const auto off_m = [&](std::size_t row) {
      return std::abs(lidar_.rows[row].vertical_offset + across_m * slopes_[row] - z);
    };
    std::size_t best = 0;
    for (std::size_t row = 1; row < slopes_.size(); ++row) {
      if (off_m(row) < off_m(best)) best = row;
    }
    double within_m = kBesideBeam_m;
    if (slopes_.size() > 1) {
      const std::size_t next = best == 0 ? 1 : best - 1;
      within_m = std::max(within_m, 0.5 * across_m * std::abs(slopes_[next] - slopes_[best]));
    }
    return off_m(best) > within_m ? slopes_.size() : best;
  }

  const PosedSweep& posed_;
  const Lidar& lidar_;
  std::vector<double> slopes_;  // [rows]
};

}  // namespace

WallsUpward::WallsUpward(const PointSet& points, double voxel_m, double up_m)
    : cell_m_(wall_cell_m(voxel_m)),
      steps_(static_cast<std::size_t>(std::lround(up_m / cell_m_))),
      columns_(columns_of_walls(wall_columns(points, cell_m_), cell_m_)),
      is_open_(columns_.size() * steps_, 0) {}

Eigen::Vector3d WallsUpward::place(std::size_t column, std::size_t step) const {
  const WallColumn& c = columns_[column];
  return {c.position_m.x(), c.position_m.y(), c.top_m + (static_cast<double>(step) + 1.0) * cell_m_};
}

void WallsUpward::look_through(const PosedSweep& posed) {
  const auto* const lidar = std::get_if<Lidar>(&posed.lidar);
  if (lidar == nullptr || posed.sweep.range.size() != lidar->ray_count()) return;
  is_requested_ = true;
  const PassingRays rays(posed, *lidar);
  parallel_each(
      columns_.size(),
      [&](std::size_t k) {
        for (std::size_t s = 0; s < steps_; ++s) {
          std::uint8_t& is_open = is_open_[k * steps_ + s];
          if (is_open == 0 && rays.go_on_at(place(k, s))) is_open = 1;
        }
      },
      64);
}

PointSet WallsUpward::points() const {
  std::vector<double> tops(columns_.size());
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const auto first = is_open_.begin() + static_cast<std::ptrdiff_t>(k * steps_);
    const auto open = std::find(first, first + static_cast<std::ptrdiff_t>(steps_), std::uint8_t{1});
    tops[k] = columns_[k].top_m + static_cast<double>(open - first) * cell_m_;
  }
  const std::vector<double> around = heights_of_walls(columns_, tops);
  std::vector<Eigen::Vector3f> found;
  PointSet out;
  for (std::size_t k = 0; k < columns_.size() && is_requested_; ++k) {
    const double top_m = std::min(tops[k], around[k]) + 1e-6;
    for (std::size_t s = 0; s < steps_ && place(k, s).z() <= top_m; ++s) {
      found.push_back(place(k, s).cast<float>());
      out.intensity.push_back(columns_[k].intensity);
    }
  }
  out.position.resize(3, static_cast<Eigen::Index>(found.size()));
  for (std::size_t i = 0; i < found.size(); ++i) out.position.col(static_cast<Eigen::Index>(i)) = found[i];
  return out;
}

GaussianSet walls_upward(const Log& log,
                         const std::vector<const SweepFrame*>& sweeps,
                         const Eigen::Vector3d& origin,
                         const PointSet& points,
                         const InitOptions& options,
                         const std::function<void()>& step) {
  if (options.lidar_walls_m == 0.0) return unmet_set({}, options);
  WallsUpward walls(points, options.voxel_m, options.lidar_walls_m);
  expect(log, sweeps);
  for (const SweepFrame* frame : sweeps) {
    walls.look_through(load_sweep(log, *frame, origin));
    step();
  }
  return unmet_set(walls.points(), options);
}

}  // namespace simuli
