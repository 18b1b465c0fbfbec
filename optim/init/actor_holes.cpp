// Fills holes in the LiDAR points of actors that pictures show.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "optim/init/initialize_actors.hpp"

namespace simuli {
namespace {

/// A box that extends this far above all its points was cut by the LiDAR's highest row: its walls continue
/// upwards from the points within kRim_m of the highest.
constexpr double kCut_m = 0.5, kRim_m = 0.7;
constexpr double kSteep = 0.1;  // smallest cosine of the incidence on a wall
constexpr double kHoleCells = 3.0;  // of a cell over a point's voxel, at the actor's distance

/// The nearest point in each cell of a picture.
class RangePicture {
 public:
  RangePicture(const Camera& camera, double cell_px)
      : cell_px_(cell_px),
        columns_(static_cast<int>(std::ceil(camera.width / cell_px))),
        rows_(static_cast<int>(std::ceil(camera.height / cell_px))),
        nearest_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), kNothing) {}
  void add(const ImageView& view, const Eigen::Vector3d& p_scene) {
    Eigen::Vector2d pixel;
    double range_m = 0.0;
    if (view.project(p_scene, pixel, range_m)) add(pixel, range_m);
  }
  void add(const Eigen::Vector2d& pixel, double range_m) {
    const Eigen::Vector2i cell = (pixel / cell_px_).cast<int>();
    used_.extend(cell);
    double& nearest = nearest_[index(cell.x(), cell.y())];
    nearest = std::min(nearest, range_m);
  }
  [[nodiscard]] double range_m(int column, int row) const { return nearest_[index(column, row)]; }
  [[nodiscard]] Eigen::Vector2d middle_px(int column, int row) const {
    return (Eigen::Vector2d(column, row).array() + 0.5) * cell_px_;
  }
  /// Empty cells with points on at least three of their four sides, with the mean range of these, near ones
  /// first.
  struct Hole {
    int column = 0, row = 0;
    double range_m = 0.0;
    int row_of_range = 0;
  };
  [[nodiscard]] std::vector<Hole> holes() const {
    std::vector<Hole> out;
    // Outside the bounding rectangle of all points a cell has points on at most one side.
    for (int row = used_.min().y(); row <= used_.max().y(); ++row) {
      for (int column = used_.min().x(); column <= used_.max().x(); ++column) {
        if (range_m(column, row) < kNothing) continue;
        constexpr std::array<std::array<int, 2>, 4> kSides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
        double sum = 0.0, weight = 0.0;
        int sides = 0;
        for (const auto& [dx, dy] : kSides) {
          int x = column + dx, y = row + dy, steps = 1;
          while (used_.contains(Eigen::Vector2i(x, y)) && range_m(x, y) == kNothing)
            x += dx, y += dy, ++steps;
          if (!used_.contains(Eigen::Vector2i(x, y))) continue;
          ++sides;
          sum += range_m(x, y) / steps;
          weight += 1.0 / steps;
        }
        if (sides >= 3) out.push_back({column, row, sum / weight, row});
      }
    }
    return out;
  }

  /// Empty cells above the highest point of their column, with that point's range.
  [[nodiscard]] std::vector<Hole> above() const {
    std::vector<Hole> out;
    for (int column = 0; column < columns_; ++column) {
      int top = 0;
      while (top < rows_ && range_m(column, top) == kNothing) ++top;
      if (top == rows_) continue;
      for (int row = 0; row < top; ++row) out.push_back({column, row, range_m(column, top), top});
    }
    return out;
  }

 private:
  static constexpr double kNothing = std::numeric_limits<double>::infinity();
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  double cell_px_;
  int columns_, rows_;
  std::vector<double> nearest_;
  Eigen::AlignedBox2i used_;  // cells, bounding rectangle of all points
};

/// Indices of items in a picture, by square.
class PictureSquares {
 public:
  explicit PictureSquares(const Camera& camera)
      : columns_(camera.width / kSide_px + 1),
        rows_(camera.height / kSide_px + 1),
        squares_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}
  /// `pixel` must be in the picture.
  void add(const Eigen::Vector2d& pixel, std::size_t what) {
    squares_[index(static_cast<int>(pixel.x()) / kSide_px, static_cast<int>(pixel.y()) / kSide_px)].push_back(
        what);
  }
  /// Visits all items in the squares that intersect an area, px, which include all items in it.
  template <class Visit>
  void visit(const Eigen::AlignedBox2d& area, Visit&& visit) const {
    const auto square = [](double at_px, int count) {
      return std::clamp(static_cast<int>(std::floor(at_px / kSide_px)), 0, count - 1);
    };
    for (int row = square(area.min().y(), rows_); row <= square(area.max().y(), rows_); ++row) {
      for (int column = square(area.min().x(), columns_); column <= square(area.max().x(), columns_);
           ++column) {
        for (const std::size_t what : squares_[index(column, row)]) visit(what);
      }
    }
  }

 private:
  static constexpr int kSide_px = 16;
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  int columns_, rows_;
  std::vector<std::vector<std::size_t>> squares_;
};

}  // namespace

void ActorPoints::add_holes(const ImageView& view,
                            double time_s,
                            const PointSet& background,
                            const PointBlocks& blocks) {
  struct Closed {  // candidate points that fill holes of one actor
    std::size_t actor = 0;
    double cell_px = 0.0, reach_m = 0.0;
    std::vector<RangePicture::Hole> holes;
    std::vector<Eigen::Vector3d> p_actor;  // [holes]
  };
  const Eigen::Vector3d eye = view.origin();
  std::vector<Closed> all;
  double farthest_m = 0.0;
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    if (!actors_[i].is_there(time_s) || points_[i].size() == 0) continue;
    const Pose pose = scene_from_actor(i, time_s);
    // Projects the actor's points into cells wide enough that its surface leaves none empty.
    const double away_m = (pose.translation - eye).norm();
    const double cell_px =
        std::max(2.0, kHoleCells * options_.voxel_m / (view.pixel_size_at_1m() * std::max(away_m, 1.0)));
    RangePicture own(view.camera(), cell_px);
    for (std::size_t k = 0; k < points_[i].size(); ++k) {
      own.add(view, pose * points_[i].position.col(static_cast<Eigen::Index>(k)).cast<double>());
    }
    const Eigen::Vector3d half = 0.5 * actors_[i].size_m;
    std::vector<RangePicture::Hole> holes = own.holes();
    const double highest_m = static_cast<double>(points_[i].position.row(2).maxCoeff());
    if (half.z() - highest_m > kCut_m) {
      RangePicture high(view.camera(), cell_px);
      for (std::size_t k = 0; k < points_[i].size(); ++k) {
        const Eigen::Vector3d p = points_[i].position.col(static_cast<Eigen::Index>(k)).cast<double>();
        if (p.z() > highest_m - kRim_m) high.add(view, pose * p);
      }
      const std::vector<RangePicture::Hole> above = high.above();
      holes.insert(holes.end(), above.begin(), above.end());
    }
    Closed closed{i, cell_px, away_m + 0.5 * actors_[i].size_m.norm(), {}, {}};
    for (const RangePicture::Hole& hole : holes) {
      Eigen::Vector3d origin, direction, measured;
      view.unproject(own.middle_px(hole.column, hole.row_of_range), origin, measured);
      view.unproject(own.middle_px(hole.column, hole.row), origin, direction);
      // Walls are vertical: the hole has the horizontal distance of the measured point.
      const double longer = measured.head<2>().norm() / std::max(direction.head<2>().norm(), kSteep);
      const double along_m = hole.row == hole.row_of_range ? hole.range_m : hole.range_m * longer;
      const Eigen::Vector3d p = pose.inverse() * Eigen::Vector3d(origin + along_m * direction);
      if (!(p.array().abs() <= half.array()).all()) continue;
      closed.holes.push_back(hole);
      closed.p_actor.push_back(p);
    }
    if (closed.holes.empty()) continue;
    farthest_m = std::max(farthest_m, closed.reach_m);
    all.push_back(std::move(closed));
  }
  if (all.empty()) return;
  // Occluders are background points; each is tested once, within its square of the picture, because actors are
  // small in it.
  const PointSet near = background.subset(blocks.seen_from(view, farthest_m));
  const std::vector<SeenPoint> before = seen_points(view, near);
  std::vector<double> away_m(before.size());
  PictureSquares squares(view.camera());
  for (std::size_t i = 0; i < before.size(); ++i) {
    away_m[i] = (near.position.col(before[i].index).cast<double>() - eye).norm();
    squares.add(before[i].pixel, i);
  }
  for (const Closed& closed : all) {
    RangePicture others(view.camera(), closed.cell_px);
    Eigen::AlignedBox2d where;
    for (const RangePicture::Hole& hole : closed.holes) where.extend(others.middle_px(hole.column, hole.row));
    const Eigen::Vector2d cell = Eigen::Vector2d::Constant(closed.cell_px);
    squares.visit({where.min() - cell, where.max() + cell}, [&](std::size_t i) {
      if (away_m[i] < closed.reach_m) others.add(before[i].pixel, before[i].range_m);
    });
    for (std::size_t k = 0; k < closed.holes.size(); ++k) {
      const RangePicture::Hole& hole = closed.holes[k];
      if (others.range_m(hole.column, hole.row) < hole.range_m) continue;
      holes_[closed.actor].add(closed.p_actor[k], 0.0);
    }
  }
}

void ActorPoints::finish_holes() {
  for (std::size_t i = 0; i < actors_.size(); ++i) camera_points_[i].append(holes_[i].averages());
}

}  // namespace simuli
