#pragma once
// The metrics of METHOD section 13: a scene beside the frames of a log. The whole recipe of `simuli eval`.
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
  EvalFrames frames;  // that were compared
  /// Of held-out frames that are of several uses: each use by itself; else nothing.
  std::optional<EvalScores> between, middle, beyond, sensor;
  /// Of each camera and LiDAR, by its name: its frames by themselves. Empty where there is one of either.
  std::vector<std::pair<std::string, EvalScores>> by_sensor;
  /// Each of frames.images and frames.sweeps by itself, in their order.
  std::vector<PictureScore> picture_scores;
  std::vector<SweepScore> sweep_scores;
  double camera_mp_per_s = kNoNumber;  // 1e6 pixels per second: median of the timed renders of one frame,
  double lidar_mr_per_s = kNoNumber;   // projection to blending, results left on the device
  int image_width = 0;                 // px, of the pictures compared
  int image_height = 0;
  std::string device;
  double seconds = 0.0;
  std::vector<std::string> warnings;  // each one sentence: labels of the log that were sanitized
};

/// Two pictures of one size.
struct PicturePair {
  Image rendered;
  Image recorded;
};
/// Two sweeps of the same rays, as the sensor states them: with what its rows' ranges are off.
struct LidarPair {
  LidarFrame rendered;
  LidarFrame recorded;
};

/// A scene on a device beside a log.
class Evaluation {
 public:
  using Progress = std::function<void(std::size_t done, std::size_t total)>;

  /// `log` as it was read: mounts, range biases, limits and blind arcs are taken from the scene, where
  /// training may have learned better. Error{kUsage} for options outside their range, Error{kInput} when no
  /// frame is left to compare.
  Evaluation(const Device& device, SceneFile scene, Log log, const EvalOptions& options = {});
  Evaluation(const Evaluation&) = delete;  // scene_on_device() looks at scene()
  Evaluation& operator=(const Evaluation&) = delete;

  [[nodiscard]] const Device& device() const { return on_device_.device(); }
  [[nodiscard]] const SceneFile& scene() const { return scene_; }
  [[nodiscard]] const Log& log() const { return log_; }
  [[nodiscard]] const EvalOptions& options() const { return options_; }
  [[nodiscard]] const EvalFrames& frames() const { return frames_; }

  /// Renders each of the frames and compares it. `progress` is called after each. Error{kInput} when one
  /// can't be read.
  [[nodiscard]] EvalReport run(const Progress& progress = {});
  /// scene() tells them from here on, if it tells how it was trained.
  void keep(const HeldOutScores& scores);
  /// A frame of log().images or log().sweeps, at the size that is compared.
  [[nodiscard]] PicturePair picture(std::size_t index);
  [[nodiscard]] LidarPair sweep(std::size_t index);

 private:
  class Run;  // over all frames

  /// A frame's camera, at the size that is compared.
  [[nodiscard]] Camera camera(const ImageFrame& frame) const;

  SceneFile scene_;
  EvalOptions options_;
  EvalFrames frames_;
  std::vector<std::string> sanitized_labels_;
  Log log_;
  SceneOnDevice on_device_;
};

}  // namespace simuli
