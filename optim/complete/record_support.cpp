#include "optim/complete/record_support.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "host/device/render/scene/scene_on_device.hpp"
#include "optim/base/evenly_spread.hpp"
#include "optim/base/frames.hpp"
#include "optim/complete/support_reliability.hpp"
#include "optim/eval/sweep_pair.hpp"

namespace simuli {
namespace {

constexpr double kLeastColourError = 0.004, kLeastContrast = 0.01;  // one and several steps of 8-bit values
constexpr double kLeastRangeError_m = 1e-3;
constexpr double kMostRangeError_m = 1.0;  // error of a missing or spurious return
constexpr float kHalf = 0.5F;

/// Cells of one view during accumulation.
class Cells {
 public:
  explicit Cells(const SupportGrid& grid) : grid_(grid), cells_(grid.cells()), counts_(grid.cells(), 0) {}

  /// Adds a ray to a point in the view's frame; a far point for a ray without hit.
  void add(const Eigen::Vector3d& p_view, double log_error, double log_contrast) {
    const std::size_t cell = grid_.cell_of(p_view);
    if (cell >= cells_.size()) return;
    const auto distance_m = static_cast<float>(std::min(p_view.norm(), kSupportFar_m));
    SupportCell& c = cells_[cell];
    c.nearest_m = counts_[cell] == 0 ? distance_m : std::min(c.nearest_m, distance_m);
    c.farthest_m = std::max(c.farthest_m, distance_m);
    c.log_error += static_cast<float>(log_error);
    c.log_contrast += static_cast<float>(log_contrast);
    ++counts_[cell];
  }

  /// Returns means; empty cells between two cells of a column with rays take the nearer one's values.
  [[nodiscard]] std::vector<SupportCell> take() && {
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (counts_[i] == 0) continue;
      cells_[i].log_error /= static_cast<float>(counts_[i]);
      cells_[i].log_contrast /= static_cast<float>(counts_[i]);
    }
    for (int column = 0; column < grid_.columns; ++column) fill(column);
    return std::move(cells_);
  }

 private:
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid_.columns) +
           static_cast<std::size_t>(column);
  }
  void fill(int column) {
    int last = -1;
    for (int row = 0; row < grid_.rows; ++row) {
      if (counts_[index(column, row)] == 0) continue;
      for (int between = last + 1; last >= 0 && between < row; ++between) {
        const int from = between - last <= row - between ? last : row;
        cells_[index(column, between)] = cells_[index(column, from)];
      }
      last = row;
    }
  }

  SupportGrid grid_;
  std::vector<SupportCell> cells_;
  std::vector<std::uint32_t> counts_;
};

/// Distance of a ray's light along the ray; far if transmittance dominates.
double met_m(const RayResults& rays, std::size_t ray) {
  return rays.transmittance[ray] < kHalf ? static_cast<double>(rays.expected_distance(ray)) : kSupportFar_m;
}

double luminance(const Image& image, int x, int y) {
  return static_cast<double>(image.at(x, y, 0) + image.at(x, y, 1) + image.at(x, y, 2)) / 3.0;
}

/// Difference between the brightest and darkest of a pixel and its neighbours.
double contrast(const Image& image, int x, int y) {
  double low = 1.0, high = 0.0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, image.height - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, image.width - 1); ++u) {
      const double here = luminance(image, u, v);
      low = std::min(low, here), high = std::max(high, here);
    }
  }
  return std::max(high - low, 0.0);
}

double range_error_m(const SweepPair& pair, std::size_t ray) {
  const bool returns = pair.recorded.range[ray] > 0.0F;
  if (returns == (pair.simulated.drop_probability(ray) > kHalf)) return kMostRangeError_m;
  if (!returns) return 0.0;
  const double off_m =
      std::abs(static_cast<double>(best_distance(pair.simulated, ray) - pair.recorded.range[ray]));
  return std::min(off_m, kMostRangeError_m);
}

class Recorder {
 public:
  Recorder(const Device& device,
           const Log& log,
           const SceneFile& scene,
           const FrameSelection& frames,
           const RenderOptions& render)
      : log_(with_sensors_of(scene, log)),
        frames_(frames),
        on_device_(device, borrowed(scene.scene), render) {
    record_->actors = scene.scene.actors;
  }

  [[nodiscard]] std::shared_ptr<const SupportRecord> record() && {
    const HeldOutRule rule(log_, frames_);
    for (const LogCamera& camera : log_.cameras) add_camera(camera, rule.training(log_.images));
    for (const LogLidar& lidar : log_.lidars) add_lidar(lidar, rule.training(log_.sweeps));
    return record_;
  }

 private:
  void add_view(double time_s, const Pose& world_from_view, Cells cells) {
    record_->views.push_back({record_->sensors.size() - 1, time_s, world_from_view});
    const std::vector<SupportCell> filled = std::move(cells).take();
    record_->cells.insert(record_->cells.end(), filled.begin(), filled.end());
  }

  void add_camera(const LogCamera& camera, const std::vector<std::size_t>& training) {
    const std::vector<std::size_t> own = own_of(
        training, log_.images, [&](const ImageFrame& frame) { return frame.camera == camera.model.name; });
    if (own.empty()) return;
    const Camera scaled = scaled_camera(camera.model, frames_.image_scale);
    record_->sensors.push_back({camera.model.name, SetKind::kCamera, support_grid(scaled)});
    for (const std::size_t i : evenly_spread(own, kMostRecordedViews)) add_picture(log_.images[i], scaled);
  }

  void add_picture(const ImageFrame& frame, const Camera& camera) {
    const Shot shot = shot_of(log_, frame);
    const Frame taken = on_device_.render(Sensor(camera), shot);
    const RayResults& rays = taken.results();
    const Image rendered = taken.image(), truth = load_image(log_, frame, camera);
    const Pose world_from_view = shot.pose_at(0.5) * grid_from_camera().inverse();
    const Pose view_from_world = world_from_view.inverse();
    Cells cells(record_->sensors.back().grid);
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
        const Eigen::Vector3d direction = camera.unproject(pixel);
        if (!(direction.squaredNorm() > 0.0) || truth.at(x, y, 0) < 0.0F) continue;  // no ray, or masked
        const std::size_t ray = static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                                static_cast<std::size_t>(x);
        const Eigen::Vector3d p_camera = met_m(rays, ray) * direction.normalized();
        const Pose view_from_camera = view_from_world * shot.pose_at(camera.exposure_fraction(pixel));
        cells.add(view_from_camera * p_camera,
                  std::log(colour_error(rendered, truth, ray) + kLeastColourError),
                  std::log(contrast(truth, x, y) + kLeastContrast));
      }
    }
    add_view(shot.middle_s(), world_from_view, std::move(cells));
  }

  void add_lidar(const LogLidar& lidar, const std::vector<std::size_t>& training) {
    const std::vector<std::size_t> own = own_of(
        training, log_.sweeps, [&](const SweepFrame& frame) { return frame.lidar == name_of(lidar.model); });
    if (own.empty()) return;
    record_->sensors.push_back({name_of(lidar.model), SetKind::kLidar, support_grid(lidar.model)});
    for (const std::size_t i : evenly_spread(own, kMostRecordedViews)) add_sweep(log_.sweeps[i], lidar.model);
  }

  void add_sweep(const SweepFrame& frame, const LidarModel& lidar) {
    const Shot shot = shot_of(log_, frame);
    const SweepPair pair = render_sweep(on_device_, log_, frame);
    const LidarRays& measured = pair.recorded.rays;
    const Pose world_from_view = shot.pose_at(0.5);
    const Pose view_from_world = world_from_view.inverse();
    Cells cells(record_->sensors.back().grid);
    for (std::size_t ray = 0; ray < pair.recorded.range.size(); ++ray) {
      const Eigen::Vector3d direction = Lidar::direction(static_cast<double>(measured.azimuth[ray]),
                                                         static_cast<double>(measured.elevation[ray]));
      const Eigen::Vector3d p_lidar =
          ray_origin(lidar, measured, ray) + met_m(pair.simulated, ray) * direction;
      const Pose view_from_lidar =
          view_from_world * shot.pose_at(static_cast<double>(measured.time_fraction[ray]));
      cells.add(view_from_lidar * p_lidar, std::log(range_error_m(pair, ray) + kLeastRangeError_m), 0.0);
    }
    add_view(shot.middle_s(), world_from_view, std::move(cells));
  }

  Log log_;
  FrameSelection frames_;
  SceneOnDevice on_device_;
  std::shared_ptr<SupportRecord> record_ = std::make_shared<SupportRecord>();
};

}  // namespace

std::shared_ptr<const SupportRecord> record_support(const Device& device,
                                                    const Log& log,
                                                    const SceneFile& scene,
                                                    const FrameSelection& frames,
                                                    const RenderOptions& render) {
  return Recorder(device, log, scene, frames, render).record();
}

}  // namespace simuli
