#pragma once
// Views of the initialisation: which image sees which point in which colour, and what no point covers.
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

/// One exposure: a camera and its pose (scene frame: world shifted by the scene origin) at the start and the
/// end of the read-out.
class ImageView {
 public:
  ImageView(Camera camera, const Pose& scene_from_camera_start, const Pose& scene_from_camera_end);

  /// Pixel and distance (m, along the ray) at which p_scene is seen, at the time at which the shutter reaches
  /// it. False when it lies behind the camera, outside the picture or where that is hidden.
  [[nodiscard]] bool project(const Eigen::Vector3d& p_scene, Eigen::Vector2d& pixel, double& range_m) const;
  /// Ray through `pixel` in the scene frame; the direction is a unit vector, or zero where the lens has no
  /// ray.
  void unproject(const Eigen::Vector2d& pixel, Eigen::Vector3d& origin, Eigen::Vector3d& direction) const;
  [[nodiscard]] const Camera& camera() const { return camera_; }
  /// Where the camera is half-way through the read-out, scene frame.
  [[nodiscard]] Eigen::Vector3d origin() const { return camera_from_scene_mid_.inverse().translation; }
  /// The same exposure by another camera in its place, e.g. camera().resized(...).
  [[nodiscard]] ImageView with_camera(const Camera& camera) const;
  /// From now on what values below 0 mark in its picture, and what is right beside that, is hidden: a mask's.
  void hide(const Image& picture);
  [[nodiscard]] bool hides(const Eigen::Vector2d& pixel) const;
  /// Side of a pixel at the optical axis, in metres at 1 m distance.
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
  std::shared_ptr<const Hidden> hidden_;  // null: nothing is
};

/// A point in a picture.
struct SeenPoint {
  std::uint32_t index = 0;
  double range_m = 0.0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};
/// Of `points` those that ImageView::project() says yes to, in their order.
[[nodiscard]] std::vector<SeenPoint> seen_points(const ImageView& view, const PointSet& points);

/// The closest look at a point over all images so far, and what all of them have shown.
struct PointObservation {
  float range_m = std::numeric_limits<float>::infinity();  // +inf: not seen
  float footprint_m = 0.0F;                                // side of a pixel at that range
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();        // [0,1]
  std::uint32_t images = 0;                                // that show it
  Eigen::AlignedBox3f colours = {};                        // of all of them
};

/// Cells of a picture into which at least one point falls.
struct Coverage {
  int cell_px = 1;
  int columns = 0;
  int rows = 0;
  std::vector<std::uint8_t> covered;  // [rows][columns]
  /// A square of cells, to kMostRadius_px to each side at most.
  void cover(const Eigen::Vector2d& pixel, double radius_px);
  /// What is right before the lens neither covers nor hides the whole picture.
  static constexpr double kMostRadius_px = 32.0;
  /// True when neither the cell nor one of its eight neighbours is covered.
  [[nodiscard]] bool is_empty_around(int column, int row) const;
};

/// How far away the nearest of some points is in each small cell of a picture.
class NearestPoints {
 public:
  explicit NearestPoints(const Camera& camera);
  /// A point as wide as `radius_px` to each side, no more than Coverage::kMostRadius_px.
  void add(const Eigen::Vector2d& pixel, double range_m, double radius_px);
  /// Whether one of them stands before what is range_m away, by more than neighbours on a road differ that is
  /// seen at a grazing angle.
  [[nodiscard]] bool hide(const Eigen::Vector2d& pixel, double range_m) const {
    return range_m - nearest_m(pixel) > least_gap_m(range_m);
  }
  /// Whether one of them is seen where something nearer would hide it.
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

/// Looks at all points through one image: each point that is not hidden by a nearer one, and that no earlier
/// image saw from closer by, takes this image's colour. Points hide what lies behind a disc of diameter
/// `point_size_m`. `image` has the size of the view's camera and 3 channels; looks: [points]. Returns the
/// coverage by the points in cells of `cell_px` pixels.
Coverage look_at_points(const ImageView& view,
                        const Image& image,
                        const PointSet& points,
                        double point_size_m,
                        int cell_px,
                        std::vector<PointObservation>& looks);

/// Least width in pixels of the camera set's voxels in the closest picture of them. Drive 0013: none 22.59 dB
/// with 424 k particles, 3 px 22.58 dB with 292 k. Street, 2 px: 32.99 dB for 32.70, the same off the path.
inline constexpr double kCameraVoxel_px = 3.0;

/// Joins points that no picture shows apart: one average point and colour is left in each voxel, of a side of
/// finest_m times the power of two nearest to `pixels` pixels of the closest look at its points (or finest_m,
/// if that is more). Points in order of side and voxel; returns by how many there are fewer.
std::size_t join_by_footprint(PointSet& points,
                              std::vector<PointObservation>& looks,
                              double finest_m,
                              double pixels);

/// Channels of a picture, bilinear at a pixel position; the border is continued outwards.
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

/// All that a picture shows lies within an angle of an axis, seen from a ball that the camera stays in.
class ViewCone {
 public:
  explicit ViewCone(const ImageView& view);
  /// Whether the picture can show anything of a ball: never a wrong no.
  [[nodiscard]] bool may_meet(const Eigen::Vector3d& centre, double radius_m) const;

 private:
  bool bounded_ = false;  // not: some of the picture's border has no ray, or the cone would be all there is
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero(), axis_ = Eigen::Vector3d::Zero();
  double moved_m_ = 0.0, half_rad_ = 0.0;
};

/// Points as balls around those that lie side by side: what of them a picture may show.
class PointBlocks {
 public:
  explicit PointBlocks(const PointSet& points);
  /// Indices of the points up to farthest_m from the view's origin that ImageView::project() can say yes to,
  /// in their order, and of some others.
  [[nodiscard]] std::vector<std::uint32_t> seen_from(
      const ImageView& view, double farthest_m = std::numeric_limits<double>::infinity()) const;
  /// Indices of the points up to farthest_m from a place, in their order, and of some others.
  [[nodiscard]] std::vector<std::uint32_t> within(const Eigen::Vector3d& from, double farthest_m) const;

 private:
  template <class F>
  [[nodiscard]] std::vector<std::uint32_t> points_of(F&& is_taken) const;
  struct Block {
    Eigen::Vector3f centre;
    float radius_m = 0.0F;
    std::size_t first = 0;  // of its points in order_, which the next block's follow
  };
  static constexpr float kSide_m = 2.0F;  // of the cube whose points are a block
  std::vector<std::uint32_t> order_;      // of the points, block by block
  std::vector<Block> blocks_;
};

/// A look at a picture's pixel where points may hide what is behind them.
struct FarObservation {
  Eigen::Vector3d origin, direction;      // in the scene
  std::optional<Eigen::Vector3f> colour;  // none: hidden
};

/// At the middles of the cells of `coverage` that have a ray there; those that are empty with their neighbours are not
/// hidden.
[[nodiscard]] std::vector<FarObservation> far_observations(const ImageView& view,
                                             const Image& image,
                                             const Coverage& coverage);

/// Directions in which images see something that no point explains: one averaged colour per cell of an equal
/// angle grid around the scene origin, at one distance.
class FarShell {
 public:
  /// Throws Error{kUsage} unless 0.05 <= spacing_deg <= 45 and distance_m > 0.
  FarShell(double spacing_deg, double distance_m);
  /// Error{kInput} unless they begin within the shell.
  void add(const std::vector<FarObservation>& looks);

  struct Patch {
    Eigen::Vector3f direction;  // unit, from the scene origin
    Eigen::Vector3f colour;
  };
  /// One patch per cell that has a colour and of whose looks at least that share were not hidden, sorted by
  /// cell. Where most meet something nothing can be far away: what looks open is a gap between points, and a
  /// patch behind it would be seen through them from elsewhere.
  [[nodiscard]] std::vector<Patch> patches(double open_share) const;
  [[nodiscard]] double spacing_rad() const { return spacing_rad_; }
  [[nodiscard]] double distance_m() const { return distance_m_; }

 private:
  struct Cell {
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // sums
    Eigen::Vector3d colour = Eigen::Vector3d::Zero();
    double open = 0.0, hidden = 0.0;  // looks
  };
  /// The direction from the scene origin of what a look meets on the shell, and its cell.
  struct Meeting {
    Eigen::Vector3d from_origin = Eigen::Vector3d::Zero();
    std::uint64_t cell = 0;
  };
  [[nodiscard]] Meeting meeting(const FarObservation& look) const;

  double spacing_rad_;
  double distance_m_;
  std::vector<double> cells_of_ring_;  // rings of equal elevation, cut into cells of about equal width
  std::unordered_map<std::uint64_t, Cell> cells_;
};

}  // namespace simuli
