#pragma once
// Walls above the laser: what stands upright where its returns end goes straight on upwards as long as
// pictures from along the path show the same there.
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

/// Where a wall was met for the last time on the way up, and what pictures show above.
struct WallColumn {
  Eigen::Vector2d position_m;  // scene x, y
  Eigen::Vector2d normal;   // unit, horizontal; to either side
  double top_m = 0.0;       // scene z
  float intensity = 0.0F;   // mean
};
/// Columns of upright points, one per square of side cell_m that holds enough of them, by square.
[[nodiscard]] std::vector<WallColumn> wall_columns(const PointSet& points, double cell_m);
/// Side of those squares, and how far apart places above are, of points in voxels of voxel_m.
[[nodiscard]] double wall_cell_m(double voxel_m);
/// Those with enough others of the same wall beside them: hedges and trees have upright places, too.
[[nodiscard]] std::vector<WallColumn> columns_of_walls(const std::vector<WallColumn>& columns, double cell_m);
/// Of each column the median top (scene z) of its wall within 1.5 m to either side. tops: [columns]
[[nodiscard]] std::vector<double> heights_of_walls(const std::vector<WallColumn>& columns,
                                                   const std::vector<double>& tops);

/// What pictures show of one place: the colours of the nearest looks at it.
class WallObservations {
 public:
  /// A look from range_m away; the farthest makes room.
  void add(float range_m, const Eigen::Vector3f& colour);
  /// Something is known to stand behind it: it can't be there.
  void refute();
  /// The colour that most of the looks agree on; none where too few do.
  [[nodiscard]] std::optional<Eigen::Vector3f> agreed() const;

 private:
  static constexpr std::size_t kMost = 8;
  using Colour = std::array<std::uint8_t, 3>;  // of 255: there are many places
  struct Look {
    float range_m;
    Colour colour;
  };
  std::array<Look, kMost> looks_{};
  std::uint16_t count_ = 0, refuted_ = 0;
};

/// Steps above its top up to which a wall goes on: the lower side of the highest edge that pictures agree on,
/// no more than `gap` steps on which they don't lying between. What has no edges may as well be the sky.
/// `agreed`: the colour at each step, if there is one.
[[nodiscard]] std::size_t wall_steps(const std::vector<std::optional<Eigen::Vector3f>>& agreed,
                                     std::size_t gap);

/// Points on walls that pictures show above what the lasers reach, of all cameras of a log.
struct WallsAbove {
  const Log& log;
  const std::vector<const ImageFrame*>& images;  // that may be read
  const Eigen::Vector3d& origin;                 // of the scene
  double image_scale;
  double voxel_m;  // side of the points' voxels; points of walls are twice as far apart
  const ActorPoints& actors;

  /// Adds to `points`, and returns how many. `step` is called after each picture.
  std::size_t add_to(PointSet& points, const std::function<void()>& step) const;
};

}  // namespace simuli
