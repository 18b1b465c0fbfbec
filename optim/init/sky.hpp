#pragma once
// Sky in recorded pictures, which has no distance.
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "io/log/log.hpp"
#include "io/picture/image.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {

/// Pixels of a picture that certainly show sky.
class SkyMask {
 public:
  SkyMask() = default;  // no sky
  /// [height][width].
  SkyMask(int width, int height, std::vector<bool> sky);

  [[nodiscard]] bool empty() const { return sky_.empty(); }
  [[nodiscard]] bool at(std::size_t pixel) const { return !sky_.empty() && sky_[pixel]; }
  /// Value at a position in the picture; positions outside are clamped.
  [[nodiscard]] bool at(const Eigen::Vector2d& pixel) const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<bool> sky_;
};

/// Finds sky in a picture of the size of the view's camera: bright areas without texture above the horizon that
/// contain hardly any return: the largest that touches the border, and similar ones. returns: [sweeps][3][n] m,
/// in the view's frame, of sweeps near the picture's time. Without returns there is no sky, because nothing
/// distinguishes it from a wall or a ceiling.
[[nodiscard]] SkyMask find_sky(const ImageView& view,
                               const Image& image,
                               const std::vector<Eigen::Matrix3Xd>& returns);

using SkyMasks = std::map<const ImageFrame*, SkyMask>;

/// Applies find_sky() to pictures of a log, with the sweep of each LiDAR that is nearest in time.
class SkyFinder {
 public:
  /// `log` and the training `sweeps` must outlive this object. `origin`: of the views.
  SkyFinder(const Log& log, std::vector<const SweepFrame*> sweeps, const Eigen::Vector3d& origin);
  /// Throws Error{kInput} when a sweep cannot be read.
  [[nodiscard]] SkyMask find(const ImageFrame& frame, const Image& image, const ImageView& view);

 private:
  using Sweeps = std::map<std::string, const SweepFrame*>;  // by LiDAR
  [[nodiscard]] Eigen::Matrix3Xd read(const SweepFrame& sweep) const;

  const Log& log_;
  std::vector<const SweepFrame*> sweeps_;
  Eigen::Vector3d origin_;
  Sweeps read_;  // the latest; cameras of one rig moment share them
  std::vector<Eigen::Matrix3Xd> returns_;
};

}  // namespace simuli
