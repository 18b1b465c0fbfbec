#include "optim/eval/evaluation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <fmt/format.h>
#include <future>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "host/core/base/fields.hpp"
#include "host/device/render/options/validate.hpp"
#include "io/log/frame_files.hpp"
#include "io/log/sanitized_labels.hpp"
#include "optim/base/evaluate_actors.hpp"
#include "optim/base/frames.hpp"
#include "optim/eval/returns_near.hpp"
#include "optim/eval/score_sums.hpp"
#include "optim/eval/sweep_pair.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {
namespace {

/// Median seconds of a render whose results stay on the device.
double time_render(const Device& device, const std::function<Frame()>& render, int repeats) {
  std::vector<double> seconds;
  for (int i = 0; i <= repeats; ++i) {
    device.finish();
    const auto begin = std::chrono::steady_clock::now();
    render().wait();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (i > 0) seconds.push_back(elapsed.count());  // the first render compiles and allocates
  }
  return median(std::move(seconds));
}

/// Compares rays that hit the world; `share_own`: share of fired rays that hit the ego vehicle.
SweepComparison compare_rays(const SweepPair& pair,
                             const LidarModel& lidar,
                             const Shot& in_scene,
                             double& share_own) {
  const LidarRays& rays = pair.recorded.rays;
  const auto* const table = std::get_if<Lidar>(&lidar);
  std::size_t fired = 0;
  SweepComparison out;
  for (std::size_t i = 0; i < pair.recorded.range.size(); ++i) {
    if (table != nullptr && !fires(*table, i)) continue;
    ++fired;
    if (hits_ego_vehicle(lidar, rays, i)) continue;
    const RayResults& r = pair.simulated;
    out.truth_range.push_back(pair.recorded.range[i]);
    out.truth_intensity.push_back(pair.recorded.intensity[i]);
    out.range.push_back(best_distance(r, i));
    out.intensity.push_back(std::clamp(r.feature[0][i], 0.0F, 1.0F));
    out.drop.push_back(r.drop_probability(i));
    const Pose scene_from_lidar = in_scene.pose_at(rays.time_fraction[i]);
    const Eigen::Vector3d origin = ray_origin(lidar, rays, i);
    const Eigen::Vector3d direction = Lidar::direction(rays.azimuth[i], rays.elevation[i]);
    out.origin.push_back((scene_from_lidar * origin).cast<float>());
    out.direction.push_back((scene_from_lidar.rotation * direction).cast<float>());
  }
  share_own = 1.0 - static_cast<double>(out.range.size()) / static_cast<double>(fired);
  return out;
}

/// Median |expected distance - range| over returned rays; NaN without any.
double expected_median_m(const SweepPair& pair) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < pair.recorded.range.size(); ++i) {
    const double range = pair.recorded.range[i];
    if (range > 0.0) errors.push_back(std::abs(pair.simulated.expected_distance(i) - range));
  }
  return errors.empty() ? std::numeric_limits<double>::quiet_NaN() : median(std::move(errors));
}

bool same_path(const Trajectory& a, const Trajectory& b) {
  return std::equal(a.poses().begin(),
                    a.poses().end(),
                    b.poses().begin(),
                    b.poses().end(),
                    [](const TimedPose& p, const TimedPose& q) {
                      return p.time_s == q.time_s && p.pose.translation == q.pose.translation &&
                             p.pose.rotation.coeffs() == q.pose.rotation.coeffs();
                    });
}

/// Removes labels that the scene's training rejected as empty.
void leave_out(const std::vector<std::string>& names, Log& log, std::vector<std::string>& reported) {
  std::erase_if(log.actors, [&](const Actor& label) {
    if (std::find(names.begin(), names.end(), label.name) == names.end()) return false;
    reported.push_back(
        fmt::format("label {}: left out by the scene's training: not scored as an actor", label.name));
    return true;
  });
}

/// Returns the log with the scene's knowledge: sanitised labels (reported in `sanitized`), its sensors, and for
/// the training log its trajectory and actors, which training may have improved.
Log as_known_by(const SceneFile& scene, bool trained_on, Log log, std::vector<std::string>& sanitized) {
  sanitized = sanitize_labels(log);
  if (trained_on) leave_out(scene.training->labels_left_out, log, sanitized);
  if (trained_on && !same_path(scene.world_from_rig, log.world_from_rig)) {
    log = on_path(std::move(log), scene.world_from_rig);
  }
  return with_sensors_of(scene, std::move(log));
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

/// Returns the distinct kinds of actors.
std::vector<std::string> kinds_of(const std::vector<Actor>& actors) {
  std::vector<std::string> kinds;
  for (const Actor& actor : actors) {
    if (std::find(kinds.begin(), kinds.end(), actor.kind) == kinds.end()) kinds.push_back(actor.kind);
  }
  return kinds;
}

/// Whether the recorded pixel is known.
bool is_known(const Image& truth, std::size_t pixel) { return truth.data[3 * pixel] >= 0.0F; }

double square_of(const Image& rendered, const Image& truth, std::size_t pixel) {
  double square = 0.0;
  for (std::size_t c = 3 * pixel; c < 3 * pixel + 3; ++c) {
    const double apart = static_cast<double>(rendered.data[c]) - static_cast<double>(truth.data[c]);
    square += apart * apart;
  }
  return square;
}

/// Frames scored concurrently with the rendering of the next; each needs several pictures.
constexpr std::size_t kScoredAtOnce = 4;

template <class Score>
struct Scored {
  Scored(FrameScore of, ErrorPools empty) : pools(std::move(empty)) {
    static_cast<FrameScore&>(score) = std::move(of);
  }
  Score score;
  ErrorPools pools;
};

/// Removes actors that the picture cannot show from `view`.
void leave_out_unseen(const Camera& camera, const std::vector<Actor>& actors, View& view) {
  const ViewCone cone(ImageView(camera, view.scene_from_sensor_start, view.scene_from_sensor_end));
  for (std::size_t i = 0; i < actors.size(); ++i) {
    const Eigen::Vector3d &start = view.actors[i].scene_from_actor_start.translation,
                          &end = view.actors[i].scene_from_actor_end.translation;
    const double radius_m = 0.5 * (actors[i].size_m.norm() + (end - start).norm());
    if (!cone.may_meet(0.5 * (start + end), radius_m)) view.actors[i].is_there = false;
  }
}

}  // namespace

/// State of one evaluation.
class Evaluation::Run {
 public:
  Run(Evaluation& of, const Progress& progress)
      : of_(of),
        progress_(progress),
        actors_(moving_actors(of.log_.actors, of.options_.actor_min_travel_m)),
        kinds_(kinds_of(actors_)),
        all_(kinds_) {
    report_.frames = of.frames_;
    report_.device = of.on_device_.device().info().label();
    report_.warnings = of.sanitized_labels_;
  }
  [[nodiscard]] EvalReport run() && {
    const auto begin = std::chrono::steady_clock::now();
    images();
    sweeps();
    static_cast<EvalScores&>(report_) = all_.scores();
    take_uses();
    take_sensors();
    report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return std::move(report_);
  }

 private:
  void images();
  void sweeps();
  void take_uses();
  void take_sensors();
  [[nodiscard]] Scored<PictureScore> score_picture(std::size_t index,
                                                   Image rendered,
                                                   const std::vector<SeenReturn>& seen) const;
  [[nodiscard]] Scored<SweepScore> score_sweep(std::size_t index, const SweepPair& pair) const;
  void pool_pixels(const ImageFrame& frame,
                   const PicturePair& pair,
                   const std::vector<SeenReturn>& seen,
                   ErrorPools& pools) const;
  void pool_rays(const SweepFrame& frame, const SweepPair& pair, ErrorPools& pools) const;
  void time_picture(const ImageFrame& frame);
  void time_sweep(const SweepFrame& frame);

  [[nodiscard]] View view_with_actors(const Shot& shot, SetKind kind) const {
    View view = view_of(of_.scene_.scene, shot, kind);
    view.actors = actors_during(actors_, shot, of_.scene_.scene.origin);
    return view;
  }
  [[nodiscard]] ErrorPool& pool_of(int actor, ErrorPools& pools) const {
    if (actor == ActorBoxes::kNone) return pools.by_kind.back();
    const auto kind = std::find(kinds_.begin(), kinds_.end(), actors_[static_cast<std::size_t>(actor)].kind);
    return pools.by_kind[static_cast<std::size_t>(kind - kinds_.begin())];
  }
  [[nodiscard]] ErrorPools pools() const { return ErrorPools(kinds_.empty() ? 0 : kinds_.size() + 1); }
  /// `uses`: of the frames, as in EvalFrames. start(index) renders a frame and scores it asynchronously; sums
  /// are added in frame order.
  template <class Score, class Start>
  [[nodiscard]] std::vector<Score> scored(const std::vector<std::size_t>& frames,
                                          const std::vector<FrameUse>& uses,
                                          const Start& start) {
    std::vector<Score> out;
    std::deque<std::future<Scored<Score>>> under_way;
    const auto take = [&] {
      auto [score, pools] = under_way.front().get();
      under_way.pop_front();
      all_.add(score, pools);
      if (!uses.empty()) by_use_.try_emplace(uses[score.index], kinds_).first->second.add(score, pools);
      by_sensor_.try_emplace(score.sensor, kinds_).first->second.add(score, pools);
      out.push_back(std::move(score));
      ++done_;
      if (progress_) progress_(done_, of_.frames_.images.size() + of_.frames_.sweeps.size());
    };
    for (const std::size_t index : frames) {
      if (under_way.size() == kScoredAtOnce) take();
      under_way.push_back(start(index));
    }
    while (!under_way.empty()) take();
    return out;
  }

  Evaluation& of_;
  const Progress& progress_;
  std::vector<Actor> actors_;  // of the log, as recorded
  std::vector<std::string> kinds_;
  ScoreSums all_;
  std::map<FrameUse, ScoreSums> by_use_;
  std::map<std::string, ScoreSums> by_sensor_;
  ReturnsNear returns_near_{of_.log_, of_.scene_.scene};
  EvalReport report_;
  std::size_t done_ = 0;
};

/// Scores each use separately when frames of several uses are compared.
void Evaluation::Run::take_uses() {
  if (by_use_.size() < 2) return;
  for (auto& [use, sums] : by_use_) {
    std::optional<EvalScores>& part = use == FrameUse::kBetween  ? report_.between
                                      : use == FrameUse::kMiddle ? report_.middle
                                      : use == FrameUse::kBeyond ? report_.beyond
                                                                 : report_.sensor;
    part = sums.scores();
  }
}

void Evaluation::Run::take_sensors() {
  std::set<std::string> cameras, lidars;
  for (const PictureScore& score : report_.picture_scores) cameras.insert(score.sensor);
  for (const SweepScore& score : report_.sweep_scores) lidars.insert(score.sensor);
  if (cameras.size() < 2 && lidars.size() < 2) return;
  for (const auto& [sensor, sums] : by_sensor_) report_.by_sensor.emplace_back(sensor, sums.scores());
}

void Evaluation::Run::time_picture(const ImageFrame& frame) {
  const Camera model = of_.camera(frame);
  const Sensor camera(model);
  const Shot shot = shot_of(of_.log_, frame);
  const double seconds = time_render(
      of_.device(), [&] { return of_.on_device_.render(camera, shot); }, of_.options_.timed_renders);
  report_.camera_mp_per_s = static_cast<double>(camera.ray_count()) / seconds / 1e6;
  report_.image_width = model.width;
  report_.image_height = model.height;
}

void Evaluation::Run::images() {
  const EvalFrames& frames = of_.frames_;
  if (!frames.images.empty()) time_picture(of_.log_.images[frames.images.front()]);
  report_.picture_scores = scored<PictureScore>(frames.images, frames.image_uses, [this](std::size_t index) {
    const ImageFrame& frame = of_.log_.images[index];
    const Camera camera = of_.camera(frame);
    return std::async([this,
                       index,
                       rendered = of_.on_device_.render(Sensor(camera), shot_of(of_.log_, frame)).image(),
                       seen = returns_near_.in(frame, camera)]() mutable {
      return score_picture(index, std::move(rendered), seen);
    });
  });
}

Scored<PictureScore> Evaluation::Run::score_picture(std::size_t index,
                                                    Image rendered,
                                                    const std::vector<SeenReturn>& seen) const {
  const ImageFrame& frame = of_.log_.images[index];
  const PicturePair pair{std::move(rendered), load_image(of_.log_, frame, of_.camera(frame))};
  Scored<PictureScore> out({index, frame.camera, frame.time_start_s}, pools());
  out.score.psnr_db = psnr_db(pair.rendered, pair.recorded);
  out.score.ssim = ssim(pair.rendered, pair.recorded);
  out.score.flip = flip(pair.rendered, pair.recorded);
  out.score.psnr_corrected_db = psnr_corrected_db(pair.rendered, pair.recorded);
  pool_pixels(frame, pair, seen, out.pools);
  return out;
}

void Evaluation::Run::pool_pixels(const ImageFrame& frame,
                                  const PicturePair& pair,
                                  const std::vector<SeenReturn>& seen,
                                  ErrorPools& pools) const {
  const auto add = [&](ErrorPool& pool, std::size_t pixel) {
    if (is_known(pair.recorded, pixel)) pool.add_pixel(square_of(pair.rendered, pair.recorded, pixel));
  };
  if (!actors_.empty()) {
    const Camera camera = of_.camera(frame);
    View view = view_with_actors(shot_of(of_.log_, frame), SetKind::kCamera);
    leave_out_unseen(camera, actors_, view);
    const auto on = pixels_on_actors({actors_, view}, camera);
    for (std::size_t i = 0; i < on.size(); ++i) add(pool_of(on[i], pools), i);
  }
  for (const SeenReturn& s : seen) add(pools.at(s.range_m), s.pixel);
}

void Evaluation::Run::time_sweep(const SweepFrame& frame) {
  const LidarModel& lidar = of_.log_.lidar(frame.lidar).model;
  const Sensor sensor = Sensor(lidar).with_rays(read_sweep(of_.log_, frame, lidar).rays);
  const Shot shot = shot_of(of_.log_, frame);
  const double seconds = time_render(
      of_.device(), [&] { return of_.on_device_.render(sensor, shot); }, of_.options_.timed_renders);
  report_.lidar_mr_per_s = static_cast<double>(sensor.ray_count()) / seconds / 1e6;
}

void Evaluation::Run::sweeps() {
  const EvalFrames& frames = of_.frames_;
  if (!frames.sweeps.empty()) time_sweep(of_.log_.sweeps[frames.sweeps.front()]);
  report_.sweep_scores = scored<SweepScore>(frames.sweeps, frames.sweep_uses, [this](std::size_t index) {
    return std::async([this, index, pair = render_sweep(of_.on_device_, of_.log_, of_.log_.sweeps[index])] {
      return score_sweep(index, pair);
    });
  });
}

Scored<SweepScore> Evaluation::Run::score_sweep(std::size_t index, const SweepPair& pair) const {
  const SweepFrame& frame = of_.log_.sweeps[index];
  const Shot in_scene = shot_of(of_.log_, frame).relative_to(of_.scene_.scene.origin);
  Scored<SweepScore> out({index, frame.lidar, frame.time_start_s}, pools());
  out.score.metrics =
      compare_sweep(compare_rays(pair, of_.log_.lidar(frame.lidar).model, in_scene, out.score.share_own));
  out.score.expected_median_m = expected_median_m(pair);
  pool_rays(frame, pair, out.pools);
  return out;
}

void Evaluation::Run::pool_rays(const SweepFrame& frame, const SweepPair& pair, ErrorPools& pools) const {
  const std::vector<float>& range = pair.recorded.range;
  const LidarModel& lidar = of_.log_.lidar(frame.lidar).model;
  std::vector<int> on(range.size(), ActorBoxes::kNone);
  if (!actors_.empty()) {
    const View view = view_with_actors(shot_of(of_.log_, frame), SetKind::kLidar);
    on = returns_on_actors({actors_, view}, lidar, pair.recorded.rays, range);
  }
  for (std::size_t i = 0; i < range.size(); ++i) {
    if (hits_ego_vehicle(lidar, pair.recorded.rays, i)) continue;
    const bool drops = pair.simulated.drop_probability(i) > 0.5F;
    const float simulated = best_distance(pair.simulated, i);
    if (!(range[i] > 0.0F)) {
      if (!drops) ++pools.at(simulated).returns_of_nothing;
      continue;
    }
    const auto put = [&](ErrorPool& pool) {
      pool.errors_m.push_back(std::abs(simulated - range[i]));
      pool.met += is_met(pair, i) ? 1U : 0U;
      pool.dropped += drops ? 1U : 0U;
    };
    put(pools.at(range[i]));
    if (!kinds_.empty()) put(pool_of(on[i], pools));
  }
}

void check(const EvalOptions& options) {
  check_fields(options);
  validate(options.render);
}

Evaluation::Evaluation(const Device& device, SceneFile scene, Log log, const EvalOptions& options)
    : scene_(std::move(scene)),
      options_(checked(options)),
      frames_(select_eval_frames(log, scene_, options)),
      log_(as_known_by(scene_,
                       scene_.training && frames_.kind != FrameKind::kOtherLog,
                       std::move(log),
                       sanitized_labels_)),
      on_device_(device, borrowed(scene_.scene), options.render) {}

Camera Evaluation::camera(const ImageFrame& frame) const {
  return scaled_camera(log_.camera(frame.camera).model, frames_.requested.image_scale);
}

EvalReport Evaluation::run(const Progress& progress) { return Run(*this, progress).run(); }

void Evaluation::keep(const HeldOutScores& scores) {
  if (scene_.training) scene_.training->held_out = scores;
}

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
