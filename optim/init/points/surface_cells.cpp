#include "optim/init/points/surface_cells.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

#include "optim/init/points/point_tree.hpp"

namespace simuli {
namespace {

constexpr int kAxisBits = 21;  // as in VoxelGrid: 2^20 voxels on either side of the origin
constexpr int kLargestLevel = 7;       // 128 voxels
constexpr double kFewestFlat = 4.0;  // points: three are always coplanar
constexpr double kLeastExtent = 0.5;  // relative to a flat cell's side, along both of its axes
constexpr double kLeastCovered = 0.5;  // relative to the points of a closed surface
/// Probes around a flat cell: because its particle extends beyond the cell, the surface must continue with the
/// same intensity at this relative distance from its centre; the nearest point there may be up to kProbeReach
/// of the side or one sensor gap away.
constexpr int kProbes = 8;
constexpr float kProbeAt = 1.0F, kProbeReach = 0.35F;
constexpr std::size_t kProbePoints = 3;  // points whose intensities are compared
constexpr float kProbeOff = 3.0F;  // largest distance from the plane relative to flat_m

/// Spreads the bits of x to every third bit.
std::uint64_t spread(std::uint64_t x) {
  x &= (std::uint64_t{1} << kAxisBits) - 1;
  x = (x | x << 32U) & 0x1f00000000ffffU;
  x = (x | x << 16U) & 0x1f0000ff0000ffU;
  x = (x | x << 8U) & 0x100f00f00f00f00fU;
  x = (x | x << 4U) & 0x10c30c30c30c30c3U;
  x = (x | x << 2U) & 0x1249249249249249U;
  return x;
}

/// Moments of a group of points.
struct Sums {
  double count = 0.0, intensity = 0.0, intensity2 = 0.0;
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  // one of the points
  Eigen::Vector3d first = Eigen::Vector3d::Zero();  // of positions relative to it
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Sight sight;

  [[nodiscard]] Eigen::Matrix3d covariance() const {
    const Eigen::Vector3d mean = first / count;
    return second / count - mean * mean.transpose();
  }
  [[nodiscard]] double intensity_sd() const {
    const double mean = intensity / count;
    return std::sqrt(std::max(0.0, intensity2 / count - mean * mean));
  }
};

class CellTree {
 public:
  CellTree(const PointSet& points, const CellOptions& options) : points_(points), options_(options) {
    std::vector<std::uint64_t> keys(points.size());
    for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = key_of(position(i));
    order_.resize(points.size());
    std::iota(order_.begin(), order_.end(), 0U);
    const auto rank = [&](std::uint32_t i) {
      const Eigen::Vector3d p = position(i);
      return std::tuple(keys[i], p.x(), p.y(), p.z(), points.intensity[i]);
    };
    std::sort(order_.begin(), order_.end(), [&](auto a, auto b) { return rank(a) < rank(b); });
    keys_.reserve(order_.size());
    for (const std::uint32_t i : order_) keys_.push_back(keys[i]);
    if (options.flat_side_m > options.voxel_m && !keys_.empty()) tree_.buildIndex();
  }

  [[nodiscard]] std::vector<SurfaceCell> cells() && {
    split(0, keys_.size(), largest_level() + 1);
    return std::move(cells_);
  }

 private:
  [[nodiscard]] Eigen::Vector3d position(std::size_t i) const {
    return points_.position.col(static_cast<Eigen::Index>(i)).cast<double>();
  }
  [[nodiscard]] std::uint64_t key_of(const Eigen::Vector3d& p) const {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto voxel = static_cast<std::int64_t>(std::floor(p(axis) / options_.voxel_m));
      const auto shifted = static_cast<std::uint64_t>(voxel + (std::int64_t{1} << (kAxisBits - 1)));
      key |= spread(shifted) << static_cast<unsigned>(axis);
    }
    return key;
  }
  [[nodiscard]] double side_m(int level) const { return std::ldexp(options_.voxel_m, level); }
  [[nodiscard]] int largest_level() const {
    double reach_m = options_.flat_side_m;
    for (const Sight& s : points_.sight) {
      if (s.is_known()) reach_m = std::max(reach_m, options_.voxel_rad * static_cast<double>(s.range_m));
    }
    int level = 0;
    while (level < kLargestLevel && side_m(level + 1) <= reach_m) ++level;
    return level;
  }

  /// Splits the points [begin, end), which share a cell of `level`, into cells.
  void split(std::size_t begin, std::size_t end, int level) {
    const auto shift = static_cast<unsigned>(3 * (level - 1));
    while (begin < end) {
      std::size_t next = begin;
      while (next < end && keys_[next] >> shift == keys_[begin] >> shift) ++next;
      const Sums sums = sum(begin, next);
      const bool one = level == 1 || next - begin == 1;
      if (one || is_far(sums, side_m(level - 1)) || is_flat(sums, side_m(level - 1))) {
        add(sums, next - begin == 1 ? options_.voxel_m : side_m(level - 1));
      } else {
        split(begin, next, level - 1);
      }
      begin = next;
    }
  }

  [[nodiscard]] Sums sum(std::size_t begin, std::size_t end) const {
    Sums out;
    out.about = position(order_[begin]);
    out.count = static_cast<double>(end - begin);
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = order_[k];
      const Eigen::Vector3d p = position(i) - out.about;
      const auto intensity = static_cast<double>(points_.intensity[i]);
      out.first += p;
      out.second += p * p.transpose();
      out.intensity += intensity;
      out.intensity2 += intensity * intensity;
      if (!points_.sight.empty() && is_nearer(points_.sight[i], out.sight)) out.sight = points_.sight[i];
    }
    return out;
  }

  [[nodiscard]] bool is_far(const Sums& sums, double side) const {
    return sums.sight.is_known() && side <= options_.voxel_rad * static_cast<double>(sums.sight.range_m);
  }

  [[nodiscard]] bool is_flat(const Sums& sums, double side) const {
    if (side > options_.flat_side_m || sums.count < kFewestFlat) return false;
    if (sums.intensity_sd() > options_.alike) return false;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(sums.covariance());
    const Eigen::Vector3d& variance = solver.eigenvalues();  // ascending
    if (!(variance(0) <= options_.flat_m * options_.flat_m)) return false;
    // Points represent voxels: a square of side a has the variance a^2 / 12 along each side.
    const double voxel2 = options_.voxel_m * options_.voxel_m;
    const double narrow2 = 12.0 * variance(1) + voxel2, wide2 = 12.0 * variance(2) + voxel2;
    if (narrow2 < kLeastExtent * kLeastExtent * side * side) return false;
    const Eigen::Vector3f normal = solver.eigenvectors().col(0).cast<float>();
    // Area per point of a closed surface: a voxel's, or the sensor's sampling if sparser.
    double point_m2 = voxel2;
    if (sums.sight.is_known()) {
      point_m2 = std::max(options_.voxel_m, static_cast<double>(sums.sight.column_step_on(normal).norm())) *
                 std::max(options_.voxel_m, static_cast<double>(sums.sight.row_step_on(normal).norm()));
    }
    if (sums.count * point_m2 < kLeastCovered * std::sqrt(narrow2 * wide2)) return false;
    return goes_on(sums, static_cast<float>(side), normal, static_cast<float>(std::sqrt(point_m2)));
  }

  /// Whether the surface continues around a flat cell.
  [[nodiscard]] bool goes_on(const Sums& sums,
                             float side,
                             const Eigen::Vector3f& normal,
                             float step_m) const {
    const Eigen::Vector3f middle = (sums.about + sums.first / sums.count).cast<float>();
    const Eigen::Vector3f first = normal.unitOrthogonal(), second = normal.cross(first);
    const float reach_m = std::max(kProbeReach * side, step_m);
    const auto intensity = static_cast<float>(sums.intensity / sums.count);
    for (int k = 0; k < kProbes; ++k) {
      const float angle = 2.0F * std::numbers::pi_v<float> * static_cast<float>(k) / kProbes;
      const Eigen::Vector3f probe =
          middle + kProbeAt * side * (std::cos(angle) * first + std::sin(angle) * second);
      std::array<std::uint32_t, kProbePoints> index{};
      std::array<float, kProbePoints> distance2{};
      const std::size_t found = tree_.knnSearch(probe.data(), index.size(), index.data(), distance2.data());
      float there = 0.0F, count = 0.0F;
      for (std::size_t j = 0; j < found && distance2[j] <= reach_m * reach_m; ++j) {
        const Eigen::Vector3f p = points_.position.col(static_cast<Eigen::Index>(index[j]));
        if (std::abs(normal.dot(p - middle)) > kProbeOff * static_cast<float>(options_.flat_m)) return false;
        there += points_.intensity[index[j]];
        count += 1.0F;
      }
      if (count == 0.0F || std::abs(there / count - intensity) > static_cast<float>(options_.alike))
        return false;
    }
    return true;
  }

  void add(const Sums& sums, double side) {
    cells_.push_back({(sums.about + sums.first / sums.count).cast<float>(),
                      sums.covariance().cast<float>(),
                      static_cast<float>(sums.intensity / sums.count),
                      static_cast<float>(side),
                      static_cast<std::uint32_t>(sums.count),
                      sums.sight});
  }

  const PointSet& points_;
  const CellOptions& options_;
  CloudView cloud_{points_};
  PointTree tree_{3, cloud_, nanoflann::KDTreeSingleIndexAdaptorParams(16)};
  std::vector<std::uint32_t> order_;  // points along the Morton curve
  std::vector<std::uint64_t> keys_;   // of order_
  std::vector<SurfaceCell> cells_;
};

}  // namespace

std::vector<SurfaceCell> surface_cells(const PointSet& points, const CellOptions& options) {
  return CellTree(points, options).cells();
}

}  // namespace simuli
