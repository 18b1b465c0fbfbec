#pragma once
// Points that a scene starts from: voxel averages, deterministic thinning, spacing and local planes.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "optim/init/points/sight.hpp"

namespace simuli {

/// Whose mean distance is how far apart points are.
inline constexpr std::size_t kSpacingNeighbours = 3;

/// N points, metres from the scene origin, with LiDAR intensity in [0,1].
struct PointSet {
  Eigen::Matrix<float, 3, Eigen::Dynamic> position;  // [3, N]
  std::vector<float> intensity;                      // [N]
  std::vector<Sight> sight;                          // [N]; empty: none is known

  [[nodiscard]] std::size_t size() const { return intensity.size(); }
  /// The points at `indices`, in that order.
  [[nodiscard]] PointSet subset(const std::vector<std::uint32_t>& indices) const;
  /// Puts `others` behind these.
  void append(const PointSet& others);
};

/// Averages points per voxel. Sums are exact integers (micrometres, millionths), so the averages do not
/// depend on the order in which points come, and memory is bounded by the voxels, not the points.
class VoxelGrid {
 public:
  /// Throws Error{kUsage} unless 1 mm <= voxel_m <= 100 m.
  explicit VoxelGrid(double voxel_m);
  /// A point in metres from the scene origin; of a voxel's sights the nearest is kept. Throws Error{kInput}
  /// when it is not finite or more than 2^20 voxels from the origin.
  void add(const Eigen::Vector3d& position, double intensity, const Sight& sight = {});
  [[nodiscard]] std::size_t points() const { return points_; }
  /// One averaged point per occupied voxel, sorted by voxel (z, y, x).
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

/// Indices to keep so that at most `limit` of `count` remain: uniform, the same for the same seed, ascending.
[[nodiscard]] std::vector<std::uint32_t> thin(std::size_t count, std::size_t limit, std::uint64_t seed);

/// The surface around a point as far as its neighbours tell.
struct LocalShape {
  float spacing_m = 0.0F;  // mean distance to the 3 nearest points; +inf for a lone point
  bool planar = false;
  /// Local axes in the scene frame; when planar the third is the plane's normal, otherwise identity.
  Eigen::Quaternionf scene_from_local = Eigen::Quaternionf::Identity();
};

/// Spacing and plane of each point from its 8 nearest neighbours. [N]
[[nodiscard]] std::vector<LocalShape> local_shapes(const PointSet& points);

}  // namespace simuli
