#pragma once
// The metrics of METHOD section 13 on the frames that a scene was not trained on.
#include <cstddef>
#include <functional>
#include <string>

#include "host/render/scene/scene_on_device.hpp"
#include "host/scene/scene.hpp"
#include "io/log/log.hpp"
#include "optim/base/metrics.hpp"
#include "optim/eval/eval_options.hpp"

namespace simuli {

/// Means over frames. NaN where the log has no such frame; a sweep whose value is NaN (nothing predicted,
/// nothing returned) is left out of that mean and counted.
struct EvalReport {
  std::size_t images = 0;
  std::size_t sweeps = 0;
  double psnr_db = 0.0;
  double ssim = 0.0;
  double psnr_ungraded_db = 0.0;            // without colour grids; NaN when the scene has none
  SweepMetrics lidar;                       // distance: median, the mean where no median exists
  double distance_expected_median_m = 0.0;  // the same median error with expected distances alone
  /// Of the log's actors alone, NaN without any: PSNR of all pixels that look at their boxes (pooled over the
  /// pictures, whatever the scene makes of them), median |d^ - d| of the returns inside, and the share of
  /// those rays that return from the same place in the scene (is_met()): of an actor that was taken away, its
  /// ghost.
  double actor_psnr_db = 0.0;
  double actor_distance_median_m = 0.0;
  double actor_share_met = 0.0;
  std::size_t actor_pixels = 0;
  std::size_t actor_returns = 0;
  std::size_t sweeps_without_chamfer = 0;
  std::size_t sweeps_without_distance = 0;
  double camera_mp_per_s = 0.0;  // 1e6 pixels per second: median of the timed renders of one frame,
  double lidar_mr_per_s = 0.0;   // projection to blending, results left on the device
  int image_width = 0;           // px, of the pictures compared
  int image_height = 0;
  std::string device;
  double seconds = 0.0;
};

/// A held-out sweep beside what the scene says of its rays.
struct SweepPair {
  static constexpr double kSame_m = 0.3;
  RayResults simulated;
  Sweep recorded;
};
/// Whether the scene has that recorded return, too, within kSame_m of its distance.
[[nodiscard]] bool is_met(const SweepPair& pair, std::size_t ray);
/// Renders the rays of a recorded sweep. Error{kInput} when it can't be read.
[[nodiscard]] SweepPair render_sweep(SceneOnDevice& scene, const Log& log, const SweepFrame& frame);

/// Renders each held-out frame and compares it. `progress(done, total)` is called after each frame.
/// Error{kUsage} for options outside their range, Error{kInput} when no frame is held out or one can't be
/// read.
[[nodiscard]] EvalReport evaluate(const Device& device,
                                  const Log& log,
                                  const Scene& scene,
                                  const EvalOptions& options,
                                  const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli
