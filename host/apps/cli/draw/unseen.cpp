#include "host/apps/cli/draw/unseen.hpp"

#include <algorithm>

namespace simuli::cli {
namespace {

/// Returns the mid times of a camera's frames.
std::vector<double> times_of(const SceneFile& file, const std::string& camera) {
  std::vector<double> times;
  const auto spans = file.recorded_frames.find(camera);
  if (spans != file.recorded_frames.end()) {
    for (const FrameSpan& span : spans->second) times.push_back(0.5 * (span.time_start_s + span.time_end_s));
  } else {
    for (const TimedPose& pose : file.world_from_rig.poses()) times.push_back(pose.time_s);
  }
  return times;
}

void hatch(Image& image, int x0, int y0) {
  constexpr float kLeft = 0.4F, kStripe = 0.55F;
  const int stripe_px = std::max(2, image.width / 200);
  for (int y = y0; y < std::min(y0 + kUnseenBlock_px, image.height); ++y) {
    for (int x = x0; x < std::min(x0 + kUnseenBlock_px, image.width); ++x) {
      const bool is_stripe = (x + y) / stripe_px % 4 == 0;
      const float grey = (image.at(x, y, 0) + image.at(x, y, 1) + image.at(x, y, 2)) / 3.0F;
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = is_stripe ? kStripe : kLeft * grey;
    }
  }
}

}  // namespace

RecordedViews::RecordedViews(const SceneFile& file) {
  if (file.world_from_rig.poses().empty()) return;
  for (const LogCamera& camera : file.cameras) {
    for (const double time_s : times_of(file, camera.model.name)) {
      const Pose world_from_camera = file.world_from_rig.at(time_s) * camera.rig_from_camera;
      views_.push_back({&camera.model, world_from_camera.inverse(), world_from_camera.translation});
    }
  }
}

RecordedViews RecordedViews::around(const Eigen::Vector3d& p_world) const {
  RecordedViews some;
  for (auto first = views_.begin(); first != views_.end();) {
    const auto last =
        std::find_if(first, views_.end(), [&](const View& view) { return view.camera != first->camera; });
    std::vector<View> views(first, last);
    std::stable_sort(views.begin(), views.end(), [&](const View& a, const View& b) {
      return (a.p_world - p_world).squaredNorm() < (b.p_world - p_world).squaredNorm();
    });
    const std::size_t nearest = std::min(views.size(), kNearest), rest = views.size() - nearest;
    for (std::size_t i = 0; i < nearest; ++i) some.views_.push_back(views[i]);
    const std::size_t others = std::min(rest, kNearest);
    for (std::size_t k = 0; k < others; ++k) {
      some.views_.push_back(views[nearest + (2 * k + 1) * rest / (2 * others)]);
    }
    first = last;
  }
  return some;
}

bool RecordedViews::has(const Eigen::Vector3d& p_world) const {
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const std::size_t i = (last_ + k) % views_.size();
    const View& view = views_[i];
    Eigen::Vector2d pixel;
    if (!view.camera->project(view.camera_from_world * p_world, pixel)) continue;
    if (pixel.x() < 0.0 || pixel.x() > view.camera->width || pixel.y() < 0.0 ||
        pixel.y() > view.camera->height)
      continue;
    last_ = i;
    return true;
  }
  return false;
}

namespace {

/// Grid of blocks of a picture.
struct Blocks {
  int columns = 0, rows = 0;
  std::vector<int> unseen;  // [rows][columns] 1: unseen; 0: seen, or without a ray

  [[nodiscard]] int at(int column, int row) const {
    return unseen[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(column)];
  }
  /// Whether most blocks of the neighbourhood are unseen: single blocks are noise of the distances.
  [[nodiscard]] bool is_mostly_unseen(int column, int row) const {
    constexpr int kReach = 2;
    int all = 0, marked = 0;
    for (int v = std::max(row - kReach, 0); v <= std::min(row + kReach, rows - 1); ++v) {
      for (int u = std::max(column - kReach, 0); u <= std::min(column + kReach, columns - 1); ++u) {
        ++all;
        marked += at(u, v);
      }
    }
    return 2 * marked > all;
  }
};

}  // namespace

MarkedPicture with_unseen_marked(const Frame& frame, const RecordedViews& views) {
  constexpr double kSky_m = 1e5;
  constexpr float kMostLeft = 0.5F;
  const Camera& camera = frame.sensor().camera();
  MarkedPicture marked{frame.image()};
  if (views.empty()) return marked;
  const RecordedViews near = views.around(frame.shot().world_from_sensor_start.translation);
  const RayResults& rays = frame.results();
  Blocks blocks{.columns = (camera.width + kUnseenBlock_px - 1) / kUnseenBlock_px,
                .rows = (camera.height + kUnseenBlock_px - 1) / kUnseenBlock_px,
                .unseen = {}};
  std::size_t with_ray = 0, unseen = 0;
  for (int row = 0; row < blocks.rows; ++row) {
    for (int column = 0; column < blocks.columns; ++column) {
      const int x = std::min(column * kUnseenBlock_px + kUnseenBlock_px / 2, camera.width - 1);
      const int y = std::min(row * kUnseenBlock_px + kUnseenBlock_px / 2, camera.height - 1);
      const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
      const Eigen::Vector3d direction = camera.unproject(pixel);
      blocks.unseen.push_back(0);
      if (!(direction.squaredNorm() > 0.0)) continue;
      ++with_ray;
      const std::size_t ray =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(x);
      // For light from two distances the mean is between them and the median at one of them; the smaller
      // value is used.
      const float mean_m = rays.expected_distance(ray);
      const bool has_median = !rays.median.empty() && rays.median[ray] > 0.0F;
      const float depth_m = has_median ? std::min(mean_m, rays.median[ray]) : mean_m;
      const bool has_depth = rays.transmittance[ray] <= kMostLeft;
      const double distance_m = has_depth ? static_cast<double>(depth_m) : kSky_m;
      const Pose world_from_camera = frame.shot().pose_at(camera.exposure_fraction(pixel));
      const Eigen::Vector3d p_world = world_from_camera * Eigen::Vector3d(distance_m * direction);
      blocks.unseen.back() = near.has(p_world) ? 0 : 1;
    }
  }
  for (int row = 0; row < blocks.rows; ++row) {
    for (int column = 0; column < blocks.columns; ++column) {
      if (!blocks.is_mostly_unseen(column, row)) continue;
      ++unseen;
      hatch(marked.image, column * kUnseenBlock_px, row * kUnseenBlock_px);
    }
  }
  if (with_ray > 0) marked.unseen_share = static_cast<double>(unseen) / static_cast<double>(with_ray);
  return marked;
}

}  // namespace simuli::cli
