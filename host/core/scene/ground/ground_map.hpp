#pragma once
// Height of the ground from LiDAR returns.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "host/core/sensors/trajectory.hpp"

namespace simuli {

struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;                // m
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
};

/// Heights of cells of kCell_m. Objects that stand on the ground for a while do not raise it: a cell is at most
/// as high as its neighbours and a slope of kSlope allow. Mirror images below it (of cars, in wet roads and
/// windows) do not lower it: they are few, and a cell is at most kPit_m below the median around it.
class GroundMap {
 public:
  /// Adds all returns of one sweep: [3, N] m, scene frame.
  void add(const Eigen::Matrix3Xf& points);
  /// Call after the last sweep.
  void finish();
  /// Returns the ground's scene z at (x, y), bilinear between cells; no value without a known cell.
  [[nodiscard]] std::optional<double> height_m(double x, double y) const;
  /// Returns two triangles between each four cell centres, for cells connected to those of `places` (scene x,
  /// y), and for gaps that most of their neighbours close.
  [[nodiscard]] TriangleMesh mesh(const std::vector<Eigen::Vector2d>& places) const;

 private:
  using Cell = std::array<int, 2>;
  static constexpr double kCell_m = 1.0;
  static constexpr double kSlope = 0.12;
  static constexpr double kLow = 0.1;  // share of a cell's returns that are below its ground height
  static constexpr double kPit_m = 0.2;
  static constexpr int kReachCells = 5;
  [[nodiscard]] static Cell cell_of(double x, double y);

  /// Low returns of one sweep in a cell.
  struct Low {
    float z = 0.0F;
    std::uint32_t returns = 0;
  };
  [[nodiscard]] std::map<Cell, float> lows();
  [[nodiscard]] static std::map<Cell, float> without_pits(const std::map<Cell, float>& lows);
  [[nodiscard]] static std::map<Cell, float> closed(std::map<Cell, float> heights);

  std::map<Cell, std::vector<Low>> lows_;
  std::map<Cell, float> height_;
};

/// Returns the ground of a scene, m from Scene::origin, from the means of static LiDAR particles with an
/// opacity of at least 1/2.
[[nodiscard]] GroundMap ground_of(const Scene& scene);

/// Returns the part connected to the path. Empty where no ground is known below the path.
[[nodiscard]] TriangleMesh ground_mesh(const GroundMap& ground,
                                       const Scene& scene,
                                       const Trajectory& world_from_rig);

}  // namespace simuli
