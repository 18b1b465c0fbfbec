#include "optim/calibration/path/plane_map.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "host/core/base/parallel.hpp"

namespace simuli::calibration {
namespace {

constexpr int kFewestPoints = 10;
constexpr double kThickest_m = 0.04;  // range noise, pose error and roughness together
/// A plane's extent relative to its thickness, in standard deviations, and relative to the voxel's side: a row
/// of points on a wall is a line, not a plane.
constexpr double kWiderThanThick = 4.0;
constexpr double kNarrowest = 0.08;

}  // namespace

std::uint64_t voxel_key(const Eigen::Vector3d& p, double size_m) {
  constexpr std::int64_t kHalf = 1 << 20;
  constexpr std::int64_t kMask = (kHalf << 1) - 1;
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto index = static_cast<std::int64_t>(std::floor(p[axis] / size_m));
    key = key << 21U | static_cast<std::uint64_t>((index + kHalf) & kMask);
  }
  return key;
}

void PlaneMap::add(const Eigen::Vector3d& p_world) {
  for (std::size_t level = 0; level < kSizes_m.size(); ++level) {
    const double size_m = kSizes_m[level];
    const auto [place, is_new] = cell_of_voxel_[level].try_emplace(voxel_key(p_world, size_m),
                                                                   static_cast<std::uint32_t>(cells_.size()));
    if (is_new) {
      cells_.emplace_back();
      cells_.back().corner = (p_world / size_m).array().floor() * size_m;
      cells_.back().size_m = size_m;
    }
    Cell& cell = cells_[place->second];
    const Eigen::Vector3d p = p_world - cell.corner;
    cell.sum += p;
    cell.sum_outer += p * p.transpose();
    ++cell.count;
    if (!cell.is_stale) stale_.push_back(place->second);
    cell.is_stale = true;
  }
}

void PlaneMap::fit(Cell& cell) {
  cell.is_stale = false;
  if (cell.count < kFewestPoints) return;
  const Eigen::Vector3d mean = cell.sum / cell.count;
  const Eigen::Matrix3d covariance = cell.sum_outer / cell.count - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const double thickness = std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
  const double width = std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
  cell.is_plane =
      thickness <= kThickest_m && width >= kWiderThanThick * thickness && width >= kNarrowest * cell.size_m;
  cell.plane = {cell.corner + mean, solver.eigenvectors().col(0).normalized(), thickness};
}

void PlaneMap::update() {
  parallel_each(
      stale_.size(), [&](std::size_t i) { fit(cells_[stale_[i]]); }, 512);
  stale_.clear();
}

int PlaneMap::find(const Eigen::Vector3d& p_world) const {
  for (std::size_t level = 0; level < kSizes_m.size(); ++level) {
    const auto found = cell_of_voxel_[level].find(voxel_key(p_world, kSizes_m[level]));
    if (found == cell_of_voxel_[level].end()) return -1;  // smaller voxels are inside larger ones
    if (cells_[found->second].is_plane) return static_cast<int>(found->second);
  }
  return -1;
}

}  // namespace simuli::calibration
