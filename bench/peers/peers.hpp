#pragma once
// The same particles rasterised by us and ray traced on Embree.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"
#include "host/core/scene/gaussians.hpp"
#include "host/device/render/scene/renderer.hpp"

namespace simuli::bench {

struct PeersOptions {
  std::vector<std::int64_t> particles{50'000, 200'000, 1'000'000};
  int frames = 7;  // timed, after one that warms up
};

/// One sensor before the bench street of so many particles.
struct PeerCase {
  std::string sensor;
  std::int64_t particles = 0;
  SetKind kind = SetKind::kCamera;
  Spread ours_ms;             // a frame by default options, from call to result on the device
  Spread blend_ms;            // device time of blending in it
  Spread alike_ms;            // a frame with each ray's own order and exact extents, as the tracer's
  Spread prepare_ms;          // Embree: what changes of the particles with the sensor's place
  Spread trace_ms;            // Embree: rays and blending
  Spread ratio, alike_ratio;  // prepare and trace over ours
  Spread blend_ratio;         // trace alone over blending alone
  double build_ms = 0.0;      // of boxes and BVH, not counted
  /// Against the tracer: PSNR of pictures (dB), or median and mean difference of distances (m).
  double ours_psnr_db = 0.0, alike_psnr_db = 0.0;
  double ours_median_m = 0.0, alike_median_m = 0.0;
  double ours_mean_m = 0.0, alike_mean_m = 0.0;

  [[nodiscard]] bool is_camera() const { return kind == SetKind::kCamera; }
};

/// Times both in turns. Error{kUsage} when built without Embree.
[[nodiscard]] std::vector<PeerCase> run_peers(const std::string& device_request,
                                              const PeersOptions& options,
                                              const std::function<void(const std::string&)>& note);

/// peers/<sensor>_<n>k/..., and a line for each case.
[[nodiscard]] std::vector<Row> peer_rows(const std::vector<PeerCase>& cases);
[[nodiscard]] std::string peer_table(const std::vector<PeerCase>& cases);

/// The set's picture by the tracer in ray order: per-ray order, exact extents, a colour per particle and
/// frame. Error{kUsage} when built without Embree.
[[nodiscard]] RayResults traced_results(const GaussianSet& set,
                                        const SensorRays& rays,
                                        const View& view,
                                        const RenderOptions& options);

/// Root of the mean squared difference of pictures (of 1, clamped to [0, 1]) as PSNR in dB.
[[nodiscard]] double picture_psnr_db(const RayResults& a, const RayResults& b);

/// Absolute differences (m) of median distances on rays that have one in both, in rising order.
[[nodiscard]] std::vector<double> distance_differences(const RayResults& a, const RayResults& b);

}  // namespace simuli::bench
