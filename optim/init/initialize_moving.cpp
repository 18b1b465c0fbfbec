#include "optim/init/initialize_moving.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/core/base/error.hpp"
#include "host/core/base/parallel.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {
namespace {

constexpr int kMinThrough = 3;
constexpr float kFarthest_m = 70.0F;
/// Beyond 40 m only rows that are close together are conclusive: the tested rows may span 0.75 m, as those of
/// an HDL-64E at 43 m and of a Pandar64 at 86 m.
constexpr float kSurelyNear_m = 40.0F;
constexpr float kSpan_m = 0.75F;
constexpr float kNearest_m = 1.0F;
constexpr double kSlack_m = 0.1;  // far above float rounding
/// A ray ends at the point when their ranges differ by at most this, or this share of the range
/// (docs/DECISIONS.md, "Actors").
constexpr float kMargin_m = 0.5F;
constexpr float kMarginShare = 0.01F;
/// Neighbourhood of rays tested around a point: two rows above and below, two columns to either side. On a road
/// at grazing incidence the rows below return earlier, so its points are never seen through.
constexpr int kRowReach = 2;
constexpr int kColumnReach = 2;
constexpr int kPoses = 64;  // sensor poses per sweep; the sensor moves a few centimetres between them

/// Rays of one sweep, addressed by position in the sensor's frame.
class RayGrid {
 public:
  explicit RayGrid(const Lidar& lidar)
      : columns_(lidar.columns),
        first_(static_cast<float>(lidar.azimuth_first)),
        sign_(static_cast<float>(lidar.spin_sign())),
        step_(static_cast<float>(lidar.azimuth_span / lidar.columns)) {
    for (const LidarRow& row : lidar.rows) {
      slope_.push_back(static_cast<float>(std::tan(row.elevation)));
      height_.push_back(static_cast<float>(row.vertical_offset));
      offset_.push_back(static_cast<float>(row.azimuth_offset));
    }
  }

  [[nodiscard]] int rows() const { return static_cast<int>(slope_.size()); }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] float height(int row) const { return height_[static_cast<std::size_t>(row)]; }
  /// Difference of the rows' slopes.
  [[nodiscard]] float spread(int row, int other) const {
    return std::abs(slope_[static_cast<std::size_t>(row)] - slope_[static_cast<std::size_t>(other)]);
  }
  /// Column nearest to an azimuth; >= columns() outside of a partial revolution.
  [[nodiscard]] int column(float azimuth, int row) const {
    constexpr auto kTurn = static_cast<float>(2.0 * std::numbers::pi);
    float angle = sign_ * (azimuth - offset_[static_cast<std::size_t>(row)] - first_);
    angle -= kTurn * std::floor(angle / kTurn);
    const int column = static_cast<int>(std::lround(angle / step_));
    const bool is_full_turn = step_ * static_cast<float>(columns_) > kTurn - step_;
    return is_full_turn ? column % columns_ : column;
  }
  /// First row that passes below height z at distance rho from the axis; 0 or rows(): not between two rows.
  [[nodiscard]] int row_below(float rho, float z) const {
    int low = 0;
    int high = rows();
    while (low < high) {
      const int middle = (low + high) / 2;
      const auto i = static_cast<std::size_t>(middle);
      if (height_[i] + rho * slope_[i] > z) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }

 private:
  int columns_;
  float first_;
  float sign_;
  float step_;
  std::vector<float> slope_;
  std::vector<float> height_;
  std::vector<float> offset_;
};

using Transform = Eigen::Matrix<float, 3, 4>;

Eigen::Vector3f apply(const Transform& t, const Eigen::Vector3f& p) { return t.leftCols<3>() * p + t.col(3); }

/// Vote of one sweep on the point p_lidar near (row_below, column).
void vote(const Sweep& sweep,
          const RayGrid& grid,
          const Eigen::Vector3f& p_lidar,
          int row_below,
          int column,
          PointVotes& votes) {
  const float rho = std::hypot(p_lidar.x(), p_lidar.y());
  const float range_m = std::hypot(rho, p_lidar.z() - grid.height(row_below));
  const int row_begin = std::max(row_below - kRowReach, 0);
  const int row_end = std::min(row_below + kRowReach, grid.rows());
  if (range_m > kSurelyNear_m && rho * grid.spread(row_begin, row_end - 1) > kSpan_m) return;
  const float margin_m = std::max(kMargin_m, kMarginShare * range_m);
  int rays = 0;
  int returned = 0;
  float nearest_m = std::numeric_limits<float>::infinity();
  bool is_there = false;
  for (int row = row_begin; row < row_end; ++row) {
    for (int k = -kColumnReach; k <= kColumnReach; ++k) {
      const int c = (column + k + grid.columns()) % grid.columns();
      const float ray_m =
          sweep.range[static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns()) +
                      static_cast<std::size_t>(c)];
      ++rays;
      if (!(ray_m > 0.0F)) continue;
      ++returned;
      nearest_m = std::min(nearest_m, ray_m);
      is_there = is_there || std::abs(ray_m - range_m) <= margin_m;
    }
  }
  if (is_there) {
    if (votes.there < std::numeric_limits<std::uint16_t>::max()) ++votes.there;
  } else if (2 * returned >= rays && nearest_m > range_m + margin_m) {
    if (votes.through < std::numeric_limits<std::uint16_t>::max()) ++votes.through;
  }
}

}  // namespace

void vote_on_points(const Sweep& sweep,
                    const Lidar& lidar,
                    const Pose& scene_from_lidar_start,
                    const Pose& scene_from_lidar_end,
                    const PointSet& points,
                    std::vector<PointVotes>& votes,
                    const PointBlocks* blocks) {
  if (sweep.range.size() != lidar.ray_count() || votes.size() != points.size()) {
    throw Error(ErrorKind::kInternal, "vote_on_points: sweep, model, points and votes do not fit together");
  }
  const RayGrid grid(lidar);
  std::array<Transform, kPoses> lidar_from_scene;
  for (int i = 0; i < kPoses; ++i) {
    const double u = (i + 0.5) / kPoses;
    lidar_from_scene[static_cast<std::size_t>(i)] =
        interpolate(scene_from_lidar_start, scene_from_lidar_end, u)
            .inverse()
            .matrix()
            .topRows<3>()
            .cast<float>();
  }
  std::vector<std::uint32_t> near;
  if (blocks != nullptr) {
    const Pose middle =
        interpolate(scene_from_lidar_start, scene_from_lidar_end, (kPoses / 2 + 0.5) / kPoses);
    near = blocks->within(middle.translation, static_cast<double>(kFarthest_m) + kSlack_m);
  }
  parallel_each(blocks != nullptr ? near.size() : points.size(), [&](std::size_t k) {
    const std::size_t i = blocks != nullptr ? near[k] : k;
    const Eigen::Vector3f p_scene = points.position.col(static_cast<Eigen::Index>(i));
    Eigen::Vector3f p_lidar = apply(lidar_from_scene[kPoses / 2], p_scene);
    const float range_m = p_lidar.norm();
    if (!(range_m > kNearest_m && range_m < kFarthest_m)) return;
    // The beam's position and the time at which it passes the point depend on each other.
    int column = 0;
    for (int round = 0; round < 2; ++round) {
      column = std::min(grid.column(std::atan2(p_lidar.y(), p_lidar.x()), 0), grid.columns() - 1);
      p_lidar = apply(lidar_from_scene[static_cast<std::size_t>(column * kPoses / grid.columns())], p_scene);
    }
    const int row = grid.row_below(std::hypot(p_lidar.x(), p_lidar.y()), p_lidar.z());
    if (row <= 0 || row >= grid.rows()) return;
    column = grid.column(std::atan2(p_lidar.y(), p_lidar.x()), row);
    if (column >= grid.columns()) return;
    vote(sweep, grid, p_lidar, row, column, votes[i]);
  });
}

bool is_moving(const PointVotes& votes) {
  return votes.through >= kMinThrough && votes.through > votes.there;
}

}  // namespace simuli
