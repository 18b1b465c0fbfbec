#pragma once
// Initial points of a scene: voxel averages, deterministic thinning, spacing and local planes.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "optim/init/points/sight.hpp"

namespace simuli {

/// Number of neighbours whose mean distance is the spacing.
inline constexpr std::size_t kSpacingNeighbours = 3;

/// N points, metres from the scene origin, with LiDAR intensity in [0,1].
struct PointSet {
  Eigen::Matrix<float, 3, Eigen::Dynamic> position;  // [3, N]
  std::vector<float> intensity;                      // [N]
  std::vector<Sight> sight;  // [N]; empty: unknown

  [[nodiscard]] std::size_t size() const { return intensity.size(); }
  /// The points at `indices`, in that order.
  [[nodiscard]] PointSet subset(const std::vector<std::uint32_t>& indices) const;
  /// Appends `others`.
  void append(const PointSet& others);
};

/// Averages points per voxel. Sums are exact integers (micrometres, millionths), so averages do not depend on
/// the order of points, and memory is proportional to voxels, not points.
class VoxelGrid {
 public:
  /// Throws Error{kUsage} unless 1 mm <= voxel_m <= 100 m.
  explicit VoxelGrid(double voxel_m);
  /// Adds a point in metres from the scene origin; a voxel keeps the nearest sight. Throws Error{kInput} when
  /// the point is not finite or more than 2^20 voxels from the origin.
  void add(const Eigen::Vector3d& position, double intensity, const Sight& sight = {});
  [[nodiscard]] std::size_t points() const { return points_; }
  /// Returns one averaged point per occupied voxel, sorted by voxel (z, y, x).
  [[nodiscard]] PointSet averages();

 private:
  struct Cell {
    std::uint64_t key = 0;
    std::uint64_t count = 0;
    Eigen::Matrix<std::int64_t, 3, 1> offset_um{0, 0, 0};  // sum, from the voxel's corner
    std::int64_t intensity_ppm = 0;                        // sum
    Sight sight;
  };
  void merge();

  double voxel_m_;
  std::size_t points_ = 0;
  std::size_t merged_ = 0;  // the first `merged_` cells are sorted and distinct
  std::vector<Cell> cells_;
};

/// Returns ascending indices of at most `limit` of `count` elements: uniform, the same for the same seed.
[[nodiscard]] std::vector<std::uint32_t> thin(std::size_t count, std::size_t limit, std::uint64_t seed);

/// The local surface around a point, estimated from its neighbours.
struct LocalShape {
  float spacing_m = 0.0F;  // mean distance to the 3 nearest points; +inf for a lone point
  bool planar = false;
  /// Local axes in the scene frame; when planar the third is the plane's normal, otherwise identity.
  Eigen::Quaternionf scene_from_local = Eigen::Quaternionf::Identity();
};

/// Computes spacing and plane of each point from its 8 nearest neighbours. [N]
[[nodiscard]] std::vector<LocalShape> local_shapes(const PointSet& points);

}  // namespace simuli
