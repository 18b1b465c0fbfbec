#include "optim/eval/evaluation.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "host/base/fields.hpp"
#include "host/render/options/validate.hpp"
#include "optim/base/evaluate_actors.hpp"
#include "optim/base/frames.hpp"
#include "optim/eval/sweep_pair.hpp"
#include "optim/init/initialize_actors.hpp"

namespace simuli {
namespace {

/// Mean of the values that are numbers.
class Mean {
 public:
  void add(double value) {
    if (std::isnan(value)) {
      ++left_out_;
      return;
    }
    sum_ += value;
    ++count_;
  }
  [[nodiscard]] double value() const {
    return count_ > 0 ? sum_ / static_cast<double>(count_) : std::numeric_limits<double>::quiet_NaN();
  }
  [[nodiscard]] std::size_t left_out() const { return left_out_; }

 private:
  double sum_ = 0.0;
  std::size_t count_ = 0;
  std::size_t left_out_ = 0;
};

/// Median seconds of a render whose results stay on the device.
double time_render(const Device& device, const std::function<Frame()>& render, int repeats) {
  std::vector<double> seconds;
  for (int i = 0; i <= repeats; ++i) {
    device.finish();
    const auto begin = std::chrono::steady_clock::now();
    render().wait();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (i > 0) seconds.push_back(elapsed.count());  // the first compiles and allocates
  }
  return median(std::move(seconds));
}

SweepComparison compare_rays(const SweepPair& pair, const LidarModel& lidar, const Shot& in_scene) {
  const LidarRays& rays = pair.recorded.rays;
  const std::size_t count = pair.recorded.range.size();
  SweepComparison out;
  out.truth_range = pair.recorded.range;
  out.truth_intensity = pair.recorded.intensity;
  for (std::size_t i = 0; i < count; ++i) {
    const RayResults& r = pair.simulated;
    out.range.push_back(best_distance(r, i));
    out.intensity.push_back(std::clamp(r.feature[0][i], 0.0F, 1.0F));
    out.drop.push_back(r.drop_probability(i));
    const Pose scene_from_lidar = in_scene.pose_at(rays.time_fraction[i]);
    const Eigen::Vector3d origin = ray_origin(lidar, rays, i);
    const Eigen::Vector3d direction = Lidar::direction(rays.azimuth[i], rays.elevation[i]);
    out.origin.push_back((scene_from_lidar * origin).cast<float>());
    out.direction.push_back((scene_from_lidar.rotation * direction).cast<float>());
  }
  return out;
}

/// Median |expected distance - range| over returned rays; NaN without one.
double expected_median_m(const SweepPair& pair) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < pair.recorded.range.size(); ++i) {
    const double range = pair.recorded.range[i];
    if (range > 0.0) errors.push_back(std::abs(pair.simulated.expected_distance(i) - range));
  }
  return errors.empty() ? std::numeric_limits<double>::quiet_NaN() : median(std::move(errors));
}

/// The log with its sensors where the scene has them: training may have learned better.
Log with_sensors_of(const SceneFile& scene, Log log) {
  for (LogCamera& camera : log.cameras) {
    const LogCamera* const known = scene.find_camera(camera.model.name);
    if (known != nullptr) camera.rig_from_camera = known->rig_from_camera;
  }
  for (LogLidar& lidar : log.lidars) {
    const LogLidar* const known = scene.find_lidar(name_of(lidar.model));
    if (known == nullptr) continue;
    lidar.rig_from_lidar = known->rig_from_lidar;
    auto* const model = std::get_if<Lidar>(&lidar.model);
    if (model == nullptr) continue;
    const Lidar& trained = known->with_rows();
    model->blind = trained.blind;
    const std::size_t rows = std::min(model->rows.size(), trained.rows.size());
    for (std::size_t row = 0; row < rows; ++row) model->rows[row].range_bias = trained.rows[row].range_bias;
  }
  return log;
}

const EvalOptions& checked(const EvalOptions& options) {
  check(options);
  return options;
}

LidarFrame as_stated(const LidarModel& lidar, Sweep sweep) {
  LidarFrame out;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    const bool returns = sweep.range[i] > 0.0F;
    out.range.push_back(returns ? stated_range(lidar, sweep.rays, i, sweep.range[i]) : 0.0F);
    out.drop.push_back(returns ? 0.0F : 1.0F);
  }
  out.intensity = std::move(sweep.intensity);
  out.rays = std::move(sweep.rays);
  return out;
}

constexpr std::array kSweepMetrics{&SweepMetrics::distance_median_m,
                                   &SweepMetrics::medl2_m2,
                                   &SweepMetrics::mean_rel_l2,
                                   &SweepMetrics::intensity_rmse,
                                   &SweepMetrics::raydrop_accuracy,
                                   &SweepMetrics::chamfer_m2,
                                   &SweepMetrics::chamfer_m};

/// Of each metric.
struct SweepMeans {
  std::array<Mean, kSweepMetrics.size()> means;

  void add(const SweepMetrics& metrics) {
    for (std::size_t m = 0; m < means.size(); ++m) means[m].add(metrics.*kSweepMetrics[m]);
  }
  [[nodiscard]] SweepMetrics values() const {
    SweepMetrics out;
    for (std::size_t m = 0; m < means.size(); ++m) out.*kSweepMetrics[m] = means[m].value();
    return out;
  }
  [[nodiscard]] const Mean& of(double SweepMetrics::*metric) const {
    const auto found = std::find(kSweepMetrics.begin(), kSweepMetrics.end(), metric);
    return means[static_cast<std::size_t>(found - kSweepMetrics.begin())];
  }
};

}  // namespace

/// One evaluation: what its two halves share.
class Evaluation::Run {
 public:
  Run(Evaluation& of, const Progress& progress)
      : of_(of), progress_(progress), actors_(moving_actors(of.log_.actors, of.options_.actor_min_travel_m)) {
    report_.frames = of.frames_;
    report_.device = of.on_device_.device().info().label();
  }
  [[nodiscard]] EvalReport run() && {
    const auto begin = std::chrono::steady_clock::now();
    if (!of_.frames_.images.empty()) images();
    sweeps();
    report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return std::move(report_);
  }

 private:
  [[nodiscard]] ActorBoxes boxes(const Shot& shot, SetKind kind) const {
    View view = view_of(of_.scene_.scene, shot, kind);
    view.actors = actors_during(actors_, shot, of_.scene_.scene.origin);
    return {actors_, view};
  }
  void step() {
    ++done_;
    if (progress_) progress_(done_, of_.frames_.images.size() + of_.frames_.sweeps.size());
  }
  void images();
  void sweeps();
  /// Adds to the sum, over pixels and channels, of the squared errors of actors.
  void add_actor_pixels(const std::vector<bool>& on, const Image& rendered, const Image& truth);

  Evaluation& of_;
  const Progress& progress_;
  std::vector<Actor> actors_;  // of the log, as recorded
  EvalReport report_;
  std::size_t done_ = 0;
  double actor_square_ = 0.0;
};

void Evaluation::Run::add_actor_pixels(const std::vector<bool>& on,
                                       const Image& rendered,
                                       const Image& truth) {
  for (std::size_t i = 0; i < on.size(); ++i) {
    if (!on[i]) continue;
    ++report_.actor_pixels;
    for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) {
      const double apart = static_cast<double>(rendered.data[c]) - static_cast<double>(truth.data[c]);
      actor_square_ += apart * apart;
    }
  }
}

void Evaluation::Run::images() {
  SceneOnDevice& on_device = of_.on_device_;
  const Scene& scene = of_.scene_.scene;
  Mean psnr, ssim_mean, psnr_ungraded;
  for (const std::size_t index : of_.frames_.images) {
    const ImageFrame& frame = of_.log_.images[index];
    const Camera model = of_.camera(frame);
    const Sensor camera(model);
    const Shot shot = shot_of(of_.log_, frame);
    const auto render = [&] { return on_device.render(camera, shot); };
    if (index == of_.frames_.images.front()) {
      const double seconds = time_render(on_device.device(), render, of_.options_.timed_renders);
      report_.camera_mp_per_s = static_cast<double>(camera.ray_count()) / seconds / 1e6;
      report_.image_width = model.width;
      report_.image_height = model.height;
    }
    const Image rendered = render().image();
    const Image truth = load_image(of_.log_, frame, model);
    psnr.add(psnr_db(rendered, truth));
    if (!actors_.empty()) {
      add_actor_pixels(pixels_on_actors(boxes(shot, SetKind::kCamera), model), rendered, truth);
    }
    ssim_mean.add(ssim(rendered, truth));
    if (!scene.color_grids.empty()) {
      psnr_ungraded.add(psnr_db(on_device.render(camera, shot, {.graded = false}).image(), truth));
    }
    step();
  }
  report_.images = of_.frames_.images.size();
  report_.psnr_db = psnr.value();
  report_.ssim = ssim_mean.value();
  report_.psnr_ungraded_db = psnr_ungraded.value();
  if (report_.actor_pixels > 0) {
    report_.actor_psnr_db =
        -10.0 * std::log10(actor_square_ / (3.0 * static_cast<double>(report_.actor_pixels)));
  }
}

void Evaluation::Run::sweeps() {
  SceneOnDevice& on_device = of_.on_device_;
  std::vector<double> actor_errors;
  double met = 0.0;
  SweepMeans means;
  Mean expected;
  for (const std::size_t index : of_.frames_.sweeps) {
    const SweepFrame& frame = of_.log_.sweeps[index];
    const LidarModel& lidar = of_.log_.lidar(frame.lidar).model;
    const Shot shot = shot_of(of_.log_, frame);
    const SweepPair pair = render_sweep(on_device, of_.log_, frame);
    if (index == of_.frames_.sweeps.front()) {
      const Sensor sensor = Sensor(lidar).with_rays(pair.recorded.rays);
      const auto render = [&] { return on_device.render(sensor, shot); };
      const double seconds = time_render(on_device.device(), render, of_.options_.timed_renders);
      report_.lidar_mr_per_s = static_cast<double>(sensor.ray_count()) / seconds / 1e6;
    }
    if (!actors_.empty()) {
      const ActorBoxes where = boxes(shot, SetKind::kLidar);
      const auto on = returns_on_actors(where, lidar, pair.recorded.rays, pair.recorded.range);
      for (std::size_t i = 0; i < on.size(); ++i) {
        if (!on[i]) continue;
        actor_errors.push_back(std::abs(best_distance(pair.simulated, i) - pair.recorded.range[i]));
        met += is_met(pair, i) ? 1.0 : 0.0;
      }
    }
    means.add(compare_sweep(compare_rays(pair, lidar, shot.relative_to(of_.scene_.scene.origin))));
    expected.add(expected_median_m(pair));
    step();
  }
  report_.sweeps = of_.frames_.sweeps.size();
  report_.lidar = means.values();
  report_.distance_expected_median_m = expected.value();
  report_.actor_returns = actor_errors.size();
  if (!actor_errors.empty()) {
    report_.actor_share_met = met / static_cast<double>(actor_errors.size());
    report_.actor_distance_median_m = median(std::move(actor_errors));
  }
  report_.sweeps_without_chamfer = means.of(&SweepMetrics::chamfer_m).left_out();
  report_.sweeps_without_distance = means.of(&SweepMetrics::distance_median_m).left_out();
}

void check(const EvalOptions& options) {
  check_fields(options);
  validate(options.render);
}

Evaluation::Evaluation(const Device& device, SceneFile scene, Log log, const EvalOptions& options)
    : scene_(std::move(scene)),
      options_(checked(options)),
      frames_(select_eval_frames(log, scene_, options.image_scale, options.held_out_every)),
      log_(with_sensors_of(scene_, std::move(log))),
      on_device_(device, borrowed(scene_.scene), options.render) {}

Camera Evaluation::camera(const ImageFrame& frame) const {
  return scaled_camera(log_.camera(frame.camera).model, frames_.image_scale);
}

EvalReport Evaluation::run(const Progress& progress) { return Run(*this, progress).run(); }

PicturePair Evaluation::picture(std::size_t index) {
  const ImageFrame& frame = log_.images[index];
  const Camera model = camera(frame);
  return {on_device_.render(Sensor(model), shot_of(log_, frame)).image(), load_image(log_, frame, model)};
}

LidarPair Evaluation::sweep(std::size_t index) {
  const SweepFrame& frame = log_.sweeps[index];
  const LidarModel& lidar = log_.lidar(frame.lidar).model;
  SweepPair pair = render_sweep(on_device_, log_, frame);
  LidarFrame rendered = lidar_frame(lidar, pair.recorded.rays, pair.simulated);
  return {std::move(rendered), as_stated(lidar, std::move(pair.recorded))};
}

}  // namespace simuli
