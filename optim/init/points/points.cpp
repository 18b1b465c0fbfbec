#include "optim/init/points/points.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "host/core/base/parallel.hpp"
#include "host/core/base/splitmix.hpp"
#include "optim/init/points/point_tree.hpp"

namespace simuli {
namespace {

constexpr int kKeyBits = 21;
constexpr std::int64_t kHalfRange = std::int64_t{1} << (kKeyBits - 1);  // voxels on either side of the origin
constexpr std::size_t kMergeEvery = std::size_t{1} << 21U;  // cells, 88 bytes each
constexpr std::size_t kPlaneNeighbours = 8;
/// Largest ratio of smallest to middle variance of a plane (a third in standard deviation).
constexpr double kNeighbourPlaneRatio = 0.1;
/// Smallest ratio of middle to largest variance of a plane; below it points form a line, like one LiDAR ring.
constexpr double kNeighbourLineRatio = 0.02;

/// Fits a plane to the given points and sets `shape` if there is one.
void fit_plane(const PointSet& points, const std::uint32_t* indices, std::size_t count, LocalShape& shape) {
  if (count < 4) return;  // three points always define a plane
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const auto at = [&](std::size_t i) -> Eigen::Vector3d {
    return points.position.col(static_cast<Eigen::Index>(indices[i])).cast<double>();
  };
  for (std::size_t i = 0; i < count; ++i) mean += at(i);
  mean /= static_cast<double>(count);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d d = at(i) - mean;
    covariance += d * d.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d& variance = solver.eigenvalues();  // ascending
  shape.planar = variance(0) <= kNeighbourPlaneRatio * variance(1) &&
                 variance(1) >= kNeighbourLineRatio * variance(2) && variance(1) > 0.0;
  if (!shape.planar) return;
  Eigen::Matrix3d scene_from_local;
  scene_from_local.col(0) = solver.eigenvectors().col(2);
  scene_from_local.col(2) = solver.eigenvectors().col(0);
  scene_from_local.col(1) = scene_from_local.col(2).cross(scene_from_local.col(0));
  shape.scene_from_local = Eigen::Quaterniond(scene_from_local).normalized().cast<float>();
}

}  // namespace

PointSet PointSet::subset(const std::vector<std::uint32_t>& indices) const {
  PointSet out;
  out.position.resize(3, static_cast<Eigen::Index>(indices.size()));
  out.intensity.reserve(indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    out.position.col(static_cast<Eigen::Index>(i)) = position.col(static_cast<Eigen::Index>(indices[i]));
    out.intensity.push_back(intensity[indices[i]]);
    if (!sight.empty()) out.sight.push_back(sight[indices[i]]);
  }
  return out;
}

void PointSet::append(const PointSet& others) {
  const Eigen::Index count = position.cols();
  position.conservativeResize(Eigen::NoChange, count + others.position.cols());
  position.rightCols(others.position.cols()) = others.position;
  if (!sight.empty() || !others.sight.empty()) {
    sight.resize(intensity.size());
    sight.insert(sight.end(), others.sight.begin(), others.sight.end());
    sight.resize(intensity.size() + others.intensity.size());
  }
  intensity.insert(intensity.end(), others.intensity.begin(), others.intensity.end());
}

VoxelGrid::VoxelGrid(double voxel_m) : voxel_m_(voxel_m) {
  if (!(voxel_m >= 1e-3 && voxel_m <= 100.0)) {
    throw Error(ErrorKind::kUsage, fmt::format("voxel_m: found {}, allowed 0.001 to 100", voxel_m));
  }
}

void VoxelGrid::add(const Eigen::Vector3d& position, double intensity, const Sight& sight) {
  const Eigen::Vector3d voxel = (position / voxel_m_).array().floor();
  const auto half = static_cast<double>(kHalfRange);
  if (!((voxel.array() >= -half).all() && (voxel.array() < half).all() && std::isfinite(intensity))) {
    throw_input_error("points",
                      "position and intensity",
                      fmt::format("({}, {}, {}) m, {}", position.x(), position.y(), position.z(), intensity),
                      fmt::format("finite and within {:.0f} m of the scene origin", half * voxel_m_));
  }
  Cell cell;
  for (int axis = 2; axis >= 0; --axis) {
    cell.key = cell.key << kKeyBits | static_cast<std::uint64_t>(std::int64_t(voxel(axis)) + kHalfRange);
    cell.offset_um(axis) = std::llround((position(axis) - voxel(axis) * voxel_m_) * 1e6);
  }
  cell.intensity_ppm = std::llround(intensity * 1e6);
  cell.count = 1;
  cell.sight = sight;
  cells_.push_back(cell);
  ++points_;
  if (cells_.size() - merged_ >= std::max(kMergeEvery, merged_)) merge();
}

void VoxelGrid::merge() {
  Interruption::ask();
  std::sort(cells_.begin(), cells_.end(), [](const Cell& a, const Cell& b) { return a.key < b.key; });
  std::size_t out = 0;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    if (out > 0 && cells_[out - 1].key == cells_[i].key) {
      Cell& sum = cells_[out - 1];
      sum.count += cells_[i].count;
      sum.offset_um += cells_[i].offset_um;
      sum.intensity_ppm += cells_[i].intensity_ppm;
      if (is_nearer(cells_[i].sight, sum.sight)) sum.sight = cells_[i].sight;
    } else {
      cells_[out++] = cells_[i];
    }
  }
  cells_.resize(out);
  merged_ = out;
}

PointSet VoxelGrid::averages() {
  merge();
  PointSet out;
  out.position.resize(3, static_cast<Eigen::Index>(cells_.size()));
  out.intensity.reserve(cells_.size());
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kKeyBits) - 1;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    const auto count = static_cast<double>(cell.count);
    for (int axis = 0; axis < 3; ++axis) {
      const auto voxel =
          static_cast<std::int64_t>(cell.key >> static_cast<unsigned>(kKeyBits * axis) & kMask) - kHalfRange;
      const double corner_m = static_cast<double>(voxel) * voxel_m_;
      const double offset_m = static_cast<double>(cell.offset_um(axis)) * 1e-6 / count;
      out.position(axis, static_cast<Eigen::Index>(i)) = static_cast<float>(corner_m + offset_m);
    }
    out.intensity.push_back(static_cast<float>(static_cast<double>(cell.intensity_ppm) * 1e-6 / count));
    out.sight.push_back(cell.sight);
  }
  return out;
}

std::vector<std::uint32_t> thin(std::size_t count, std::size_t limit, std::uint64_t seed) {
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    throw_input_error("points", "count", std::to_string(count), "at most 4294967295");
  }
  std::vector<std::uint32_t> indices(count);
  std::iota(indices.begin(), indices.end(), 0U);
  if (count <= limit) return indices;
  // Keeps the `limit` smallest hashes: exactly that many, and lower limits keep subsets of higher ones.
  const std::uint64_t salt = splitmix(seed);
  const auto by_hash = [salt](std::uint32_t a, std::uint32_t b) {
    return std::pair{splitmix(a ^ salt), a} < std::pair{splitmix(b ^ salt), b};
  };
  std::nth_element(
      indices.begin(), indices.begin() + static_cast<std::ptrdiff_t>(limit), indices.end(), by_hash);
  indices.resize(limit);
  std::sort(indices.begin(), indices.end());
  return indices;
}

std::vector<LocalShape> local_shapes(const PointSet& points) {
  std::vector<LocalShape> shapes(points.size());
  if (points.size() == 0) return shapes;
  const CloudView cloud{points};
  PointTree tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  tree.buildIndex();
  parallel_each(points.size(), [&](std::size_t i) {
    std::array<std::uint32_t, kPlaneNeighbours + 1> indices{};  // the first is the point itself
    std::array<float, kPlaneNeighbours + 1> distance2{};
    const float* query = points.position.col(static_cast<Eigen::Index>(i)).data();
    const std::size_t found = tree.knnSearch(query, indices.size(), indices.data(), distance2.data());
    const std::size_t near = std::min(found - 1, kSpacingNeighbours);
    float sum = 0.0F;
    for (std::size_t k = 1; k <= near; ++k) sum += std::sqrt(distance2[k]);
    shapes[i].spacing_m = near > 0 ? sum / static_cast<float>(near) : std::numeric_limits<float>::infinity();
    fit_plane(points, indices.data(), found, shapes[i]);
  });
  return shapes;
}

}  // namespace simuli
