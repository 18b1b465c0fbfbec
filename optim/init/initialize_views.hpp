#pragma once
// Views of the initialisation: visibility and colours of points in images, and parts of images without points.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/sensors/camera.hpp"
#include "io/picture/image.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// One exposure: a camera and its poses (scene frame: world shifted by the scene origin) at the start and end
/// of the read-out.
class ImageView {
 public:
  ImageView(Camera camera, const Pose& scene_from_camera_start, const Pose& scene_from_camera_end);

  /// Projects p_scene at its own shutter time: pixel and distance (m, along the ray). Returns false when it is
  /// behind the camera, outside the picture, or masked.
  [[nodiscard]] bool project(const Eigen::Vector3d& p_scene, Eigen::Vector2d& pixel, double& range_m) const;
  /// Computes the ray through `pixel` in the scene frame; the direction is a unit vector, or zero where the
  /// lens has no ray.
  void unproject(const Eigen::Vector2d& pixel, Eigen::Vector3d& origin, Eigen::Vector3d& direction) const;
  [[nodiscard]] const Camera& camera() const { return camera_; }
  /// Camera position at mid-read-out, scene frame.
  [[nodiscard]] Eigen::Vector3d origin() const { return camera_from_scene_mid_.inverse().translation; }
  /// The same exposure with another camera, e.g. camera().resized(...).
  [[nodiscard]] ImageView with_camera(const Camera& camera) const;
  /// Masks pixels with negative values in its picture, and their neighbours.
  void hide(const Image& picture);
  [[nodiscard]] bool hides(const Eigen::Vector2d& pixel) const;
  /// Size of a pixel at the optical axis, in metres at 1 m distance.
  [[nodiscard]] double pixel_size_at_1m() const { return 1.0 / camera_.focal_px(); }

 private:
  [[nodiscard]] Pose scene_from_camera(const Eigen::Vector2d& pixel) const;

  Camera camera_;
  Pose start_;
  Pose end_;
  Pose camera_from_scene_mid_;
  struct Hidden {
    int width, height;
    std::vector<bool> pixels;  // [height][width]
  };
  std::shared_ptr<const Hidden> hidden_;  // null: no mask
};

/// A point in a picture.
struct SeenPoint {
  std::uint32_t index = 0;
  double range_m = 0.0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};
/// Returns the `points` for which ImageView::project() succeeds, in order.
[[nodiscard]] std::vector<SeenPoint> seen_points(const ImageView& view, const PointSet& points);

/// The nearest observation of a point over all images so far, and a summary of all observations.
struct PointObservation {
  float range_m = std::numeric_limits<float>::infinity();  // +inf: not seen
  float footprint_m = 0.0F;                                // size of a pixel at that range
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();        // [0,1]
  std::uint32_t images = 0;                                // number of images that show it
  Eigen::AlignedBox3f colours = {};                        // range of the colours in these
};

/// Cells of a picture that contain at least one point.
struct Coverage {
  int cell_px = 1;
  int columns = 0;
  int rows = 0;
  std::vector<std::uint8_t> covered;  // [rows][columns]
  /// Covers a square of cells, at most kMostRadius_px to each side.
  void cover(const Eigen::Vector2d& pixel, double radius_px);
  /// Limits the effect of points right in front of the lens.
  static constexpr double kMostRadius_px = 32.0;
  /// Whether the cell and its eight neighbours are empty.
  [[nodiscard]] bool is_empty_around(int column, int row) const;
};

/// The nearest range of points in each small cell of a picture.
class NearestPoints {
 public:
  explicit NearestPoints(const Camera& camera);
  /// Adds a point with half width `radius_px`, at most Coverage::kMostRadius_px.
  void add(const Eigen::Vector2d& pixel, double range_m, double radius_px);
  /// Whether a point is in front of range_m by more than neighbouring points differ on a road at grazing
  /// incidence.
  [[nodiscard]] bool hide(const Eigen::Vector2d& pixel, double range_m) const {
    return range_m - nearest_m(pixel) > least_gap_m(range_m);
  }
  /// Whether a point is visible where a nearer one would occlude it.
  [[nodiscard]] bool are_seen_through(const Eigen::Vector2d& pixel, double range_m) const {
    const double there_m = nearest_m(pixel);
    return std::isfinite(there_m) && there_m - range_m > least_gap_m(range_m);
  }

 private:
  static constexpr int kCell_px = 2;
  static double least_gap_m(double range_m) { return 0.05 * range_m + 0.3; }
  [[nodiscard]] std::size_t cell_of(int x, int y) const;
  [[nodiscard]] double nearest_m(const Eigen::Vector2d& pixel) const;

  int columns_, rows_;
  std::vector<float> nearest_m_;  // [rows][columns], +inf: none
};

/// Observes all points in one image: each point that is not occluded and that no earlier image observed from
/// nearer takes this image's colour. A point occludes a disc of diameter `point_size_m`. `image` has the size
/// of the view's camera and 3 channels; observations: [points]. Returns the coverage by points in cells of `cell_px`
/// pixels.
Coverage look_at_points(const ImageView& view,
                        const Image& image,
                        const PointSet& points,
                        double point_size_m,
                        int cell_px,
                        std::vector<PointObservation>& observations);

/// Smallest width in pixels of the camera set's voxels in their nearest picture (docs/DECISIONS.md,
/// "Initialisation").
inline constexpr double kCameraVoxel_px = 3.0;

/// Merges points that no picture resolves: one average point and colour per voxel, of side finest_m times the
/// power of two nearest to `pixels` pixels of the nearest observation (at least finest_m). Sorts points by side
/// and voxel; returns the number of removed points.
std::size_t join_by_footprint(PointSet& points,
                              std::vector<PointObservation>& observations,
                              double finest_m,
                              double pixels);

/// Bilinear channels of a picture at a pixel position; the border is extended.
template <int kChannels, class Scalar>
[[nodiscard]] Eigen::Matrix<float, kChannels, 1> sample_bilinear(const Image& image,
                                                                 const Eigen::Matrix<Scalar, 2, 1>& pixel) {
  constexpr auto kHalf = static_cast<Scalar>(0.5);
  const Scalar x = std::clamp(pixel.x() - kHalf, Scalar{0}, static_cast<Scalar>(image.width - 1));
  const Scalar y = std::clamp(pixel.y() - kHalf, Scalar{0}, static_cast<Scalar>(image.height - 1));
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, image.width - 1);
  const int y1 = std::min(y0 + 1, image.height - 1);
  const auto u = static_cast<float>(x - static_cast<Scalar>(x0));
  const auto v = static_cast<float>(y - static_cast<Scalar>(y0));
  Eigen::Matrix<float, kChannels, 1> out;
  for (int c = 0; c < kChannels; ++c) {
    const float top = (1.0F - u) * image.at(x0, y0, c) + u * image.at(x1, y0, c);
    const float bottom = (1.0F - u) * image.at(x0, y1, c) + u * image.at(x1, y1, c);
    out(c) = (1.0F - v) * top + v * bottom;
  }
  return out;
}

/// A cone that contains all view rays of a picture, from a ball that contains the moving camera.
class ViewCone {
 public:
  explicit ViewCone(const ImageView& view);
  /// Conservative test whether the picture can show part of a ball.
  [[nodiscard]] bool may_meet(const Eigen::Vector3d& centre, double radius_m) const;

 private:
  bool bounded_ = false;  // false: a border pixel has no ray, or the cone would be the whole space
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero(), axis_ = Eigen::Vector3d::Zero();
  double moved_m_ = 0.0, half_rad_ = 0.0;
};

/// Points grouped in bounding balls for fast visibility tests.
class PointBlocks {
 public:
  explicit PointBlocks(const PointSet& points);
  /// Returns in order a superset of the indices of points within farthest_m of the view's origin for which
  /// ImageView::project() succeeds.
  [[nodiscard]] std::vector<std::uint32_t> seen_from(
      const ImageView& view, double farthest_m = std::numeric_limits<double>::infinity()) const;
  /// Returns in order a superset of the indices of points within farthest_m of a position.
  [[nodiscard]] std::vector<std::uint32_t> within(const Eigen::Vector3d& from, double farthest_m) const;

 private:
  template <class F>
  [[nodiscard]] std::vector<std::uint32_t> points_of(F&& is_taken) const;
  struct Block {
    Eigen::Vector3f centre;
    float radius_m = 0.0F;
    std::size_t first = 0;  // index in order_ of its first point; the next block follows
  };
  static constexpr float kSide_m = 2.0F;  // side of a block's cube
  std::vector<std::uint32_t> order_;      // points, block by block
  std::vector<Block> blocks_;
};

/// A picture's view along a ray beyond the points, which may occlude it.
struct FarObservation {
  Eigen::Vector3d origin, direction;      // in the scene frame
  std::optional<Eigen::Vector3f> colour;  // no value: occluded
};

/// Returns observations at the centres of the cells of `coverage` that have a ray; empty cells with empty
/// neighbours are not occluded.
[[nodiscard]] std::vector<FarObservation> far_observations(const ImageView& view,
                                                           const Image& image,
                                                           const Coverage& coverage);

/// Directions in which images show objects without points: one averaged colour per cell of an equal-angle grid
/// around the scene origin, at one distance.
class FarShell {
 public:
  /// Throws Error{kUsage} unless 0.05 <= spacing_deg <= 45 and distance_m > 0.
  FarShell(double spacing_deg, double distance_m);
  /// Throws Error{kInput} unless the rays begin inside the shell.
  void add(const std::vector<FarObservation>& observations);

  struct Patch {
    Eigen::Vector3f direction;  // unit, from the scene origin
    Eigen::Vector3f colour;
  };
  /// Returns one patch per cell with a colour where at least that share of observations is not occluded, sorted
  /// by cell. Where most observations are occluded, open ones look through gaps between points, and a distant
  /// patch would be visible through them from elsewhere.
  [[nodiscard]] std::vector<Patch> patches(double open_share) const;
  [[nodiscard]] double spacing_rad() const { return spacing_rad_; }
  [[nodiscard]] double distance_m() const { return distance_m_; }

 private:
  struct Cell {
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // sums
    Eigen::Vector3d colour = Eigen::Vector3d::Zero();
    double open = 0.0, hidden = 0.0;  // number of observations
  };
  /// Direction from the scene origin of an observation's intersection with the shell, and its cell.
  struct Meeting {
    Eigen::Vector3d from_origin = Eigen::Vector3d::Zero();
    std::uint64_t cell = 0;
  };
  [[nodiscard]] Meeting meeting(const FarObservation& look) const;

  double spacing_rad_;
  double distance_m_;
  std::vector<double> cells_of_ring_;  // rings of equal elevation, divided into cells of about equal width
  std::unordered_map<std::uint64_t, Cell> cells_;
};

}  // namespace simuli
