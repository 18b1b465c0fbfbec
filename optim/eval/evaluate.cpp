#include "optim/eval/evaluate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/render/scene/look.hpp"
#include "host/render/scene/seen.hpp"
#include "optim/base/evaluate_actors.hpp"
#include "optim/base/frames.hpp"
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
double time_render(Renderer& renderer, const std::function<void()>& render, int repeats) {
  std::vector<double> seconds;
  for (int i = 0; i <= repeats; ++i) {
    renderer.device().finish();
    const auto begin = std::chrono::steady_clock::now();
    render();
    renderer.device().finish();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (i > 0) seconds.push_back(elapsed.count());  // the first compiles and allocates
  }
  return median(std::move(seconds));
}

SweepComparison compare_rays(const SweepPair& pair, const LidarModel& lidar, const View& view) {
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
    const Pose scene_from_lidar =
        interpolate(view.scene_from_sensor_start, view.scene_from_sensor_end, rays.time_fraction[i]);
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

/// One evaluation: what its two halves share.
struct Evaluation {
  const Log& log;
  const Scene& scene;
  const EvalOptions& options;
  Renderer& renderer;
  const std::function<void()>& step;
  EvalReport& report;
  std::vector<Actor> actors;  // of the log, as recorded

  [[nodiscard]] ActorBoxes boxes(View view, double time_start_s, double time_end_s) const {
    view.actors = actors_during(actors, time_start_s, time_end_s, scene.origin);
    return {actors, view};
  }
  void images(const std::vector<std::size_t>& frames);
  void sweeps(const std::vector<std::size_t>& frames);
};

void Evaluation::images(const std::vector<std::size_t>& frames) {
  const ParticleBuffers particles(renderer.device(), scene.camera, renderer.options());
  std::map<std::string, std::unique_ptr<SensorRays>> rays_of;
  SceneLook look(renderer.device(), scene, renderer.options().precision);
  SceneLook ungraded(renderer.device(), scene, renderer.options().precision, false);
  Mean psnr, ssim_mean, psnr_ungraded;
  double actor_square = 0.0;  // sum over pixels and channels
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const ImageFrame& frame = log.images[frames[k]];
    const Camera model = scaled_camera(log.camera(frame.camera).model, options.image_scale);
    auto& rays = rays_of[frame.camera];
    if (!rays) rays = std::make_unique<SensorRays>(renderer.device(), model, renderer.options());
    const View view = view_of(log, scene, frame);
    const double time_s = 0.5 * (frame.time_start_s + frame.time_end_s);
    const auto render = [&] { return look.render(renderer, particles, *rays, view, frame.camera, time_s); };
    if (k == 0) {
      const double seconds = time_render(renderer, render, options.timed_renders);
      report.camera_mp_per_s = static_cast<double>(rays->grid().rays) / seconds / 1e6;
      report.image_width = model.width;
      report.image_height = model.height;
    }
    const Image rendered = picture_of(render().results(), model);
    const Image truth = load_image(log, frame, model);
    psnr.add(psnr_db(rendered, truth));
    if (!actors.empty()) {
      const std::vector<bool> on = pixels_on_actors(boxes(view, frame.time_start_s, frame.time_end_s), model);
      for (std::size_t i = 0; i < on.size(); ++i) {
        if (!on[i]) continue;
        ++report.actor_pixels;
        for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) {
          const double apart = static_cast<double>(rendered.data[c]) - static_cast<double>(truth.data[c]);
          actor_square += apart * apart;
        }
      }
    }
    ssim_mean.add(ssim(rendered, truth));
    if (!scene.color_grids.empty()) {
      const Pass pass = ungraded.render(renderer, particles, *rays, view, frame.camera, time_s);
      psnr_ungraded.add(psnr_db(picture_of(pass.results(), model), truth));
    }
    step();
  }
  report.images = frames.size();
  report.psnr_db = psnr.value();
  report.ssim = ssim_mean.value();
  report.psnr_ungraded_db = psnr_ungraded.value();
  if (report.actor_pixels > 0) {
    report.actor_psnr_db =
        -10.0 * std::log10(actor_square / (3.0 * static_cast<double>(report.actor_pixels)));
  }
}

void Evaluation::sweeps(const std::vector<std::size_t>& frames) {
  const ParticleBuffers particles(renderer.device(), scene.lidar, renderer.options());
  std::vector<double> actor_errors;
  double met = 0.0;
  Mean distance, medl2, rel, intensity, drop, chamfer2, chamfer, expected;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const SweepFrame& frame = log.sweeps[frames[k]];
    const LidarModel& lidar = log.lidar(frame.lidar).model;
    const View view = view_of(log, scene, frame);
    const SweepPair pair = render_sweep(renderer, particles, log, scene, frame);
    if (k == 0) {
      const SensorRays rays(renderer.device(), lidar, pair.recorded.rays, renderer.options());
      const auto render = [&] { renderer.render(particles, rays, view); };
      const double seconds = time_render(renderer, render, options.timed_renders);
      report.lidar_mr_per_s = static_cast<double>(rays.grid().rays) / seconds / 1e6;
    }
    if (!actors.empty()) {
      const ActorBoxes where = boxes(view, frame.time_start_s, frame.time_end_s);
      const auto on = returns_on_actors(where, lidar, pair.recorded.rays, pair.recorded.range);
      for (std::size_t i = 0; i < on.size(); ++i) {
        if (!on[i]) continue;
        actor_errors.push_back(std::abs(best_distance(pair.simulated, i) - pair.recorded.range[i]));
        met += is_met(pair, i) ? 1.0 : 0.0;
      }
    }
    const SweepMetrics m = compare_sweep(compare_rays(pair, lidar, view));
    distance.add(m.distance_median_m);
    medl2.add(m.medl2_m2);
    rel.add(m.mean_rel_l2);
    intensity.add(m.intensity_rmse);
    drop.add(m.raydrop_accuracy);
    chamfer2.add(m.chamfer_m2);
    chamfer.add(m.chamfer_m);
    expected.add(expected_median_m(pair));
    step();
  }
  report.sweeps = frames.size();
  report.lidar = {distance.value(),
                  medl2.value(),
                  rel.value(),
                  intensity.value(),
                  drop.value(),
                  chamfer2.value(),
                  chamfer.value()};
  report.distance_expected_median_m = expected.value();
  report.actor_returns = actor_errors.size();
  if (!actor_errors.empty()) {
    report.actor_share_met = met / static_cast<double>(actor_errors.size());
    report.actor_distance_median_m = median(std::move(actor_errors));
  }
  report.sweeps_without_chamfer = chamfer.left_out();
  report.sweeps_without_distance = distance.left_out();
}

}  // namespace

bool is_met(const SweepPair& pair, std::size_t ray) {
  const RayResults& r = pair.simulated;
  return r.drop_probability(ray) < 0.5F &&
         std::abs(best_distance(r, ray) - pair.recorded.range[ray]) < SweepPair::kSame_m;
}

SweepPair render_sweep(Renderer& renderer,
                       const ParticleBuffers& lidar_set,
                       const Log& log,
                       const Scene& scene,
                       const SweepFrame& frame) {
  const LidarModel& lidar = log.lidar(frame.lidar).model;
  SweepPair pair;
  pair.recorded = read_sweep(log.folder / frame.file, lidar);
  const SensorRays rays(renderer.device(), lidar, pair.recorded.rays, renderer.options());
  pair.simulated = renderer.render(lidar_set, rays, view_of(log, scene, frame)).results();
  return pair;
}

EvalReport evaluate(const Device& device,
                    const Log& log,
                    const Scene& scene,
                    const EvalOptions& options,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
  if (options.timed_renders < 1 || options.held_out_every < 0 || options.held_out_every == 1) {
    throw Error(ErrorKind::kUsage,
                fmt::format("evaluate: found held_out_every {}, timed_renders {}, allowed 0 or at least 2, "
                            "at least 1",
                            options.held_out_every,
                            options.timed_renders));
  }
  const auto begin = std::chrono::steady_clock::now();
  // Nothing held out: every frame is "not held out", and all of them are compared.
  const bool held_out = options.held_out_every > 0;
  const auto images = select_frames(log.images, options.held_out_every, held_out);
  const auto sweeps = select_frames(log.sweeps, options.held_out_every, held_out);
  if (images.empty() && sweeps.empty()) {
    throw_input_error(log.folder.string(),
                      "held-out frames",
                      "0",
                      fmt::format("at least one: a log of {} frames or more", options.held_out_every));
  }
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EvalReport report;
  report.psnr_db = report.ssim = report.psnr_ungraded_db = report.camera_mp_per_s = report.lidar_mr_per_s =
      kNaN;
  report.lidar = {kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN};
  report.distance_expected_median_m = kNaN;
  report.actor_psnr_db = report.actor_distance_median_m = report.actor_share_met = kNaN;
  report.device = device.info().label();
  Renderer renderer(device, options.render);
  std::size_t done = 0;
  const std::function<void()> step = [&] {
    ++done;
    if (progress) progress(done, images.size() + sweeps.size());
  };
  Evaluation evaluation{
      log, scene, options, renderer, step, report, moving_actors(log.actors, options.actor_min_travel_m)};
  if (!images.empty()) evaluation.images(images);
  if (!sweeps.empty()) evaluation.sweeps(sweeps);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report;
}

}  // namespace simuli
