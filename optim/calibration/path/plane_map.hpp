#pragma once
// A map of planes: voxels that accumulate points, and fitted planes.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

namespace simuli::calibration {

/// Key of the voxel of side size_m that contains p; unique within 2^20 voxels of the origin.
[[nodiscard]] std::uint64_t voxel_key(const Eigen::Vector3d& p, double size_m);

struct Plane {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   // m, mean of its points
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, arbitrary sign
  double thickness_m = 0.0;  // standard deviation of its points along the normal
};

/// Voxels in two sizes. Lookups prefer planes of large voxels, which more points determine.
class PlaneMap {
 public:
  static constexpr std::array<double, 2> kSizes_m{1.0, 0.5};

  /// Adds a point (m, world). Planes are those of the last update().
  void add(const Eigen::Vector3d& p_world);
  /// Fits planes of voxels with new points.
  void update();
  /// Index of the plane of the voxel that contains p; -1 without one. Indices are stable when points are added.
  [[nodiscard]] int find(const Eigen::Vector3d& p_world) const;
  [[nodiscard]] const Plane& plane(int number) const {
    return cells_[static_cast<std::size_t>(number)].plane;
  }
  [[nodiscard]] std::size_t cells() const { return cells_.size(); }

 private:
  struct Cell {
    Eigen::Vector3d corner;  // origin of the sums
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d sum_outer = Eigen::Matrix3d::Zero();
    int count = 0;
    double size_m = 0.0;
    bool is_plane = false;
    bool is_stale = false;
    Plane plane;
  };
  static void fit(Cell& cell);

  std::array<std::unordered_map<std::uint64_t, std::uint32_t>, kSizes_m.size()> cell_of_voxel_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> stale_;
};

}  // namespace simuli::calibration
