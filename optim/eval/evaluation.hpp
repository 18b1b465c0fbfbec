#pragma once
// Metrics of METHOD section 13: compares a scene with the frames of a log. The complete recipe of `simuli
// eval`.
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/eval/eval_frames.hpp"
#include "optim/eval/eval_options.hpp"
#include "optim/eval/eval_scores.hpp"

namespace simuli {

struct EvalReport : EvalScores {
  EvalFrames frames;  // compared frames
  /// Held-out frames of several uses: scores of each use; otherwise no values.
  std::optional<EvalScores> between, middle, beyond, sensor;
  /// Scores by name of camera or LiDAR. Empty with one sensor of a kind.
  std::vector<std::pair<std::string, EvalScores>> by_sensor;
  /// Scores of each of frames.images and frames.sweeps, in order.
  std::vector<PictureScore> picture_scores;
  std::vector<SweepScore> sweep_scores;
  double camera_mp_per_s = kNoNumber;  // 1e6 pixels per second: median of the timed renders of one frame,
  double lidar_mr_per_s = kNoNumber;   // projection to blending, results left on the device
  int image_width = 0;                 // px, of the compared pictures
  int image_height = 0;
  std::string device;
  double seconds = 0.0;
  std::vector<std::string> warnings;  // one sentence each: sanitised labels of the log
};

/// Calls value(key, value) for each part of a report, with the keys of all outputs: texts, numbers, lists of texts,
/// vectors of scores, optional EvalScores, and the pairs of by_sensor.
template <class F>
void visit_report(const EvalReport& r, F&& value) {
  value("frames", std::string(to_string(r.frames.kind)));
  value("held_out_every", r.frames.requested.held_out_every);
  value("held_out_middle", r.frames.requested.held_out_middle);
  value("held_out_last", r.frames.requested.held_out_last);
  value("held_out_sensors", r.frames.requested.held_out_sensors);
  value("image_scale", r.frames.requested.image_scale);
  visit_scores(static_cast<const EvalScores&>(r), value);
  value("by_picture", r.picture_scores);
  value("by_sweep", r.sweep_scores);
  value("between", r.between);
  value("middle", r.middle);
  value("beyond", r.beyond);
  value("sensor", r.sensor);
  value("by_sensor", r.by_sensor);
  value("camera_mp_per_s", r.camera_mp_per_s);
  value("lidar_mr_per_s", r.lidar_mr_per_s);
  value("image_width_px", r.image_width);
  value("image_height_px", r.image_height);
  value("device", r.device);
  value("seconds", r.seconds);
  value("warnings", r.warnings);
}

/// Two pictures of one size.
struct PicturePair {
  Image rendered;
  Image recorded;
};
/// Two sweeps of the same rays, as the sensor reports them, including range biases.
struct LidarPair {
  LidarFrame rendered;
  LidarFrame recorded;
};

/// A scene on a device and a log to compare it with.
class Evaluation {
 public:
  using Progress = std::function<void(std::size_t done, std::size_t total)>;

  /// `log` as it was read: mountings, range biases, limits and blind arcs come from the scene, where training
  /// may have improved them. Throws Error{kUsage} for options outside their range, Error{kInput} when no frame
  /// is left to compare.
  Evaluation(const Device& device, SceneFile scene, Log log, const EvalOptions& options = {});
  Evaluation(const Evaluation&) = delete;  // scene_on_device() refers to scene()
  Evaluation& operator=(const Evaluation&) = delete;

  [[nodiscard]] const Device& device() const { return on_device_.device(); }
  [[nodiscard]] const SceneFile& scene() const { return scene_; }
  [[nodiscard]] const Log& log() const { return log_; }
  [[nodiscard]] const EvalOptions& options() const { return options_; }
  [[nodiscard]] const EvalFrames& frames() const { return frames_; }

  /// Renders and compares each frame; calls `progress` after each. Throws Error{kInput} when a frame cannot be
  /// read.
  [[nodiscard]] EvalReport run(const Progress& progress = {});
  /// Stores the scores in scene(), if it has a training record.
  void keep(const HeldOutScores& scores);
  /// A frame of log().images or log().sweeps, at the compared size.
  [[nodiscard]] PicturePair picture(std::size_t index);
  [[nodiscard]] LidarPair sweep(std::size_t index);

 private:
  class Run;  // over all frames

  /// A frame's camera, at the compared size.
  [[nodiscard]] Camera camera(const ImageFrame& frame) const;

  SceneFile scene_;
  EvalOptions options_;
  EvalFrames frames_;
  std::vector<std::string> sanitized_labels_;
  Log log_;
  SceneOnDevice on_device_;
};

}  // namespace simuli
