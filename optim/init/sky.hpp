#pragma once
// Sky in recorded pictures: what has no distance.
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "io/log/log.hpp"
#include "io/picture/image.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {

/// Which pixels of a picture show sky for sure.
class SkyMask {
 public:
  SkyMask() = default;  // none do
  /// [height][width].
  SkyMask(int width, int height, std::vector<bool> sky);

  [[nodiscard]] bool empty() const { return sky_.empty(); }
  [[nodiscard]] bool at(std::size_t pixel) const { return !sky_.empty() && sky_[pixel]; }
  /// At a place in the picture; beyond its border what is nearest.
  [[nodiscard]] bool at(const Eigen::Vector2d& pixel) const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<bool> sky_;
};

/// Of a picture as large as the view's camera: areas without texture above the horizon that are not dark and in which
/// next to no return lies: the largest of them that touches the border, and what is like it. returns: [sweeps][3][n]
/// m, in the view's frame, of sweeps taken next to the picture. Without any nothing is sky: nothing else tells a wall
/// or a ceiling from it.
[[nodiscard]] SkyMask find_sky(const ImageView& view,
                               const Image& image,
                               const std::vector<Eigen::Matrix3Xd>& returns);

using SkyMasks = std::map<const ImageFrame*, SkyMask>;

/// find_sky() in pictures of a log, by the sweep of each LiDAR that is nearest in time.
class SkyFinder {
 public:
  /// `log` and `sweeps`, those that may be read, must outlive it. `origin`: of the views.
  SkyFinder(const Log& log, std::vector<const SweepFrame*> sweeps, const Eigen::Vector3d& origin);
  /// Error{kInput} when a sweep can't be read.
  [[nodiscard]] SkyMask find(const ImageFrame& frame, const Image& image, const ImageView& view);

 private:
  using Sweeps = std::map<std::string, const SweepFrame*>;  // by LiDAR
  [[nodiscard]] Eigen::Matrix3Xd read(const SweepFrame& sweep) const;

  const Log& log_;
  std::vector<const SweepFrame*> sweeps_;
  Eigen::Vector3d origin_;
  Sweeps read_;  // the last ones: the cameras of a rig's moment share them
  std::vector<Eigen::Matrix3Xd> returns_;
};

}  // namespace simuli
