// ImageView of optim/init/initialize_views.hpp.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "host/core/sensors/own_time.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {

ImageView::ImageView(Camera camera, const Pose& scene_from_camera_start, const Pose& scene_from_camera_end)
    : camera_(std::move(camera)),
      start_(scene_from_camera_start),
      end_(scene_from_camera_end),
      camera_from_scene_mid_(interpolate(start_, end_, 0.5).inverse()) {}

Pose ImageView::scene_from_camera(const Eigen::Vector2d& pixel) const {
  return interpolate(start_, end_, camera_.exposure_fraction(pixel));
}

bool ImageView::project(const Eigen::Vector3d& p_scene, Eigen::Vector2d& pixel, double& range_m) const {
  // Motion during the read-out shifts a point by far less than a quarter of the picture; points farther outside
  // cannot enter it. Each iteration contracts by (shift / height): three are sufficient.
  constexpr OwnTimeAccuracy kAccuracy{.most = 3, .settled_px = 0.01, .margin = 0.25};
  Eigen::Vector3d p_camera;
  const auto at = [&](double share) -> const Eigen::Vector3d& {
    if (share == 0.5) return p_camera = camera_from_scene_mid_ * p_scene;
    const Pose pose = interpolate(start_, end_, share);
    return p_camera = pose.rotation.conjugate() * (p_scene - pose.translation);
  };
  const std::optional<OwnTimeImage> image = image_at_own_time(camera_, at, kAccuracy);
  if (!image) return false;
  pixel = image->pixel;
  range_m = p_camera.norm();
  return is_inside(camera_, pixel) && !hides(pixel);
}

ImageView ImageView::with_camera(const Camera& camera) const {
  ImageView out{camera, start_, end_};
  out.hidden_ = hidden_;
  return out;
}

void ImageView::hide(const Image& picture) {
  const auto hidden = std::make_shared<Hidden>();
  *hidden = {picture.width, picture.height, std::vector<bool>(picture.data.size() / 3, false)};
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
           static_cast<std::size_t>(x);
  };
  bool any = false;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (picture.at(x, y, 0) >= 0.0F) continue;
      any = true;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, picture.height - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, picture.width - 1); ++u)
          hidden->pixels[at(u, v)] = true;
      }
    }
  }
  hidden_ = any ? hidden : nullptr;
}

bool ImageView::hides(const Eigen::Vector2d& pixel) const {
  if (hidden_ == nullptr) return false;
  const auto index = [](double at, int of, int count) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(std::floor(at * count / of)), 0, count - 1));
  };
  return hidden_
      ->pixels[index(pixel.y(), camera_.height, hidden_->height) * static_cast<std::size_t>(hidden_->width) +
               index(pixel.x(), camera_.width, hidden_->width)];
}

void ImageView::unproject(const Eigen::Vector2d& pixel,
                          Eigen::Vector3d& origin,
                          Eigen::Vector3d& direction) const {
  const Pose pose = scene_from_camera(pixel);
  origin = pose.translation;
  direction = pose.rotation * camera_.unproject(pixel);
}

}  // namespace simuli
