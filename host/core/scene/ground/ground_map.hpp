#pragma once
// How high the ground is below what LiDARs have met.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "host/core/scene/ground/triangle_mesh.hpp"

namespace simuli {

/// Heights of cells of kCell_m. What stands on the ground for a while does not lift it: a cell is no higher
/// than its neighbours and a slope of kSlope allow. Nor do mirror images below it (of cars, in wet roads and
/// windows) lower it: they are few, and a cell lies no more than kPit_m below the median of those around.
class GroundMap {
 public:
  /// All returns of one sweep: [3, N] m, scene frame.
  void add(const Eigen::Matrix3Xf& points);
  /// After the last sweep.
  void finish();
  /// Scene z of the ground at (x, y), bilinear between cells; none where no cell is known.
  [[nodiscard]] std::optional<double> height_m(double x, double y) const;
  /// Two triangles between each four cells' centres: of the cells that hang together with those of `places`
  /// (scene x, y), and of the gaps between them that most of their neighbours close.
  [[nodiscard]] TriangleMesh mesh(const std::vector<Eigen::Vector2d>& places) const;

 private:
  using Cell = std::array<int, 2>;
  static constexpr double kCell_m = 1.0;
  static constexpr double kSlope = 0.12;
  static constexpr double kLow = 0.1;  // share of the returns of a cell that are lower than its ground
  static constexpr double kPit_m = 0.2;
  static constexpr int kReachCells = 5;
  [[nodiscard]] static Cell cell_of(double x, double y);

  /// What one sweep says of a cell.
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

}  // namespace simuli
