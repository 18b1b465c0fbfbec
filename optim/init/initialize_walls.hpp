#pragma once
// Walls above the LiDARs' field of view: a vertical surface where returns end continues upwards as long as
// pictures along the path show consistent colours.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "io/log/log.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// The highest returns of a wall, and the pictures' colours above.
struct WallColumn {
  Eigen::Vector2d position_m;  // scene x, y
  Eigen::Vector2d normal;      // unit, horizontal; to either side
  double top_m = 0.0;          // scene z
  float intensity = 0.0F;      // mean
};
/// Finds columns of vertical points, one per square of side cell_m with enough of them, sorted by square.
[[nodiscard]] std::vector<WallColumn> wall_columns(const PointSet& points, double cell_m);
/// Returns the side of these squares and the vertical spacing, for points in voxels of voxel_m.
[[nodiscard]] double wall_cell_m(double voxel_m);
/// Keeps columns with enough neighbours on the same wall: hedges and trees have vertical parts, too.
[[nodiscard]] std::vector<WallColumn> columns_of_walls(const std::vector<WallColumn>& columns, double cell_m);
/// Returns for each column the median top (scene z) of its wall within 1.5 m to either side. tops: [columns]
[[nodiscard]] std::vector<double> heights_of_walls(const std::vector<WallColumn>& columns,
                                                   const std::vector<double>& tops);

/// Colours of the nearest observations of one position.
class WallObservations {
 public:
  /// Adds an observation at range_m; replaces the farthest.
  void add(float range_m, const Eigen::Vector3f& colour);
  /// Marks that a surface is visible behind the position, which is therefore empty.
  void refute();
  /// Returns the colour that most observations agree on; no value when too few do.
  [[nodiscard]] std::optional<Eigen::Vector3f> agreed() const;

 private:
  static constexpr std::size_t kMost = 8;
  using Colour = std::array<std::uint8_t, 3>;  // compact, because there are many positions
  struct Observation {
    float range_m;
    Colour colour;
  };
  std::array<Observation, kMost> observations_{};
  std::uint16_t count_ = 0, refuted_ = 0;
};

/// Returns the number of steps by which a wall continues above its top: up to the lower side of the highest
/// colour edge that pictures agree on, with gaps of at most `gap` steps without agreement. Without edges the
/// colours could be sky. `agreed`: colour at each step, if any.
[[nodiscard]] std::size_t wall_steps(const std::vector<std::optional<Eigen::Vector3f>>& agreed,
                                     std::size_t gap);

/// Points on walls that pictures show above the LiDARs' field of view, for all cameras of a log.
struct WallsAbove {
  const Log& log;
  const std::vector<const ImageFrame*>& images;  // readable training images
  const Eigen::Vector3d& origin;                 // origin of the scene
  double image_scale;
  double voxel_m;  // of the points; wall points have twice the spacing
  const ActorPoints& actors;

  /// Adds to `points` and returns the number. Calls `step` after each picture.
  std::size_t add_to(PointSet& points, const std::function<void()>& step) const;
};

}  // namespace simuli
