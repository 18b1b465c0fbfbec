#include "optim/init/ground_near.hpp"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "host/core/base/spread.hpp"

namespace simuli {
namespace {

constexpr double kReach_m = 8.0;  // about the second ring of a LiDAR on a roof
constexpr double kApart_m = 0.5;  // between rig positions
constexpr double kOnGround_m = 0.3;  // height tolerance of ground points

using Square = std::array<int, 2>;

/// Median height of the rig above the ground along its path.
std::optional<double> clearance_m(const GroundMap& ground, const std::vector<Pose>& scene_from_rig) {
  std::vector<double> all;
  for (const Pose& pose : scene_from_rig) {
    const Eigen::Vector3d& p = pose.translation;
    if (const auto z = ground.height_m(p.x(), p.y())) all.push_back(p.z() - *z);
  }
  if (all.empty()) return std::nullopt;
  return upper_median(std::move(all));
}

}  // namespace

PointSet ground_near(const GroundMap& ground,
                     const std::vector<Pose>& scene_from_rig,
                     const PointSet& points,
                     double voxel_m) {
  const std::optional<double> clearance = clearance_m(ground, scene_from_rig);
  if (!clearance) return {};
  const double side_m = 2.0 * voxel_m;
  const auto square_of = [side_m](double x, double y) {
    return Square{static_cast<int>(std::floor(x / side_m)), static_cast<int>(std::floor(y / side_m))};
  };
  // Ground height of each square, from the nearest rig position.
  struct Near {
    double distance_m = kReach_m, z_m = 0.0;
  };
  std::map<Square, Near> squares;
  std::optional<Eigen::Vector3d> last;
  const int reach = static_cast<int>(std::ceil(kReach_m / side_m));
  for (const Pose& pose : scene_from_rig) {
    if (last && (pose.translation - *last).norm() < kApart_m) continue;
    last = pose.translation;
    const Eigen::Vector3d below = pose * Eigen::Vector3d(0.0, 0.0, -*clearance);
    const Eigen::Vector3d up = pose.rotation * Eigen::Vector3d::UnitZ();
    const Square middle = square_of(below.x(), below.y());
    for (int dx = -reach; dx <= reach; ++dx) {
      for (int dy = -reach; dy <= reach; ++dy) {
        const Square square{middle[0] + dx, middle[1] + dy};
        const Eigen::Vector2d to =
            Eigen::Vector2d((square[0] + 0.5) * side_m, (square[1] + 0.5) * side_m) - below.head<2>();
        const double distance_m = to.norm();
        if (distance_m >= kReach_m) continue;
        Near& near = squares[square];
        if (distance_m < near.distance_m) near = {distance_m, below.z() - up.head<2>().dot(to) / up.z()};
      }
    }
  }
  for (auto& [square, near] : squares) {
    const auto z = ground.height_m((square[0] + 0.5) * side_m, (square[1] + 0.5) * side_m);
    if (z) near.z_m = *z;
  }
  std::set<Square> taken;
  for (Eigen::Index i = 0; i < points.position.cols(); ++i) {
    const Eigen::Vector3d p = points.position.col(i).cast<double>();
    const auto found = squares.find(square_of(p.x(), p.y()));
    if (found != squares.end() && std::abs(p.z() - found->second.z_m) < kOnGround_m)
      taken.insert(found->first);
  }
  VoxelGrid grid(voxel_m);
  for (const auto& [square, near] : squares) {
    if (taken.contains(square)) continue;
    grid.add({(square[0] + 0.5) * side_m, (square[1] + 0.5) * side_m, near.z_m}, 0.0);
  }
  return grid.averages();
}

}  // namespace simuli
