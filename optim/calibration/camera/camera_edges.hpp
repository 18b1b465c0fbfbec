#pragma once
// Depth edges of LiDAR sweeps, which cameras also see as edges.
#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "io/log/log.hpp"
#include "optim/calibration/camera/luminance.hpp"

namespace simuli::calibration {

/// A point at the edge of a foreground surface. The edge lies within `half_width` of it along `across`, between
/// two neighbouring firings of which one hits the foreground.
struct DepthEdge {
  Eigen::Vector3d p_rig = Eigen::Vector3d::Zero();    // m, at time_s
  Eigen::Vector3d across = Eigen::Vector3d::UnitY();  // unit, rig; away from the foreground
  double half_width = 0.0;                            // m
  double time_s = 0.0;
};

/// Returns edges along rows and columns of a sweep, at most farthest_m away. Neighbours without a return are
/// ignored: glass, sky and black paint are indistinguishable.
[[nodiscard]] std::vector<DepthEdge> depth_edges(const Sweep& sweep,
                                                 const LogLidar& lidar,
                                                 double time_start_s,
                                                 double time_end_s,
                                                 double farthest_m = 60.0);

/// A picture prepared for edge search.
class EdgeImage {
 public:
  /// Blurs by a Gaussian of sigma_px.
  EdgeImage(const Luminance& picture, double sigma_px) : picture_(picture.blurred(sigma_px)) {}

  /// Whether the pixel is unmasked.
  [[nodiscard]] bool is_open(const Eigen::Vector2d& pixel) const {
    return !std::isnan(picture_.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())));
  }

  struct Edge {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  // unit, towards the brighter side
    double strength = 0.0;                              // luminance per pixel
  };
  /// Finds the strongest edge within reach_px of `pixel` along the unit `direction`, preferring near ones, that
  /// is perpendicular enough to the direction; false below least_strength. None next to masked pixels.
  [[nodiscard]] bool find(const Eigen::Vector2d& pixel,
                          const Eigen::Vector2d& direction,
                          double reach_px,
                          double least_strength,
                          Edge& edge) const;

 private:
  [[nodiscard]] Eigen::Vector2d gradient(const Eigen::Vector2d& pixel) const;

  Luminance picture_;
};

}  // namespace simuli::calibration
