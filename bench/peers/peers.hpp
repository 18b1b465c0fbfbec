#pragma once
// Compares rasterisation with ray tracing of the same particles with Embree.
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
  int frames = 7;  // timed frames, after one warm-up frame
};

/// One sensor in the bench street with this number of particles.
struct PeerCase {
  std::string sensor;
  std::int64_t particles = 0;
  SetKind kind = SetKind::kCamera;
  Spread ours_ms;             // a frame with default options, from the call to the result on the device
  Spread blend_ms;            // device time of its blending
  Spread alike_ms;            // a frame with per-ray order and exact extents, as in the tracer
  Spread prepare_ms;          // Embree: update of particles for the sensor position
  Spread trace_ms;            // Embree: rays and blending
  Spread ratio, alike_ratio;  // prepare and trace over ours
  Spread blend_ratio;         // trace relative to blending
  double build_ms = 0.0;      // of boxes and BVH, not included
  /// Difference to the tracer: PSNR of pictures (dB), or median and mean difference of distances (m).
  double ours_psnr_db = 0.0, alike_psnr_db = 0.0;
  double ours_median_m = 0.0, alike_median_m = 0.0;
  double ours_mean_m = 0.0, alike_mean_m = 0.0;

  [[nodiscard]] bool is_camera() const { return kind == SetKind::kCamera; }
};

/// Times both in turns. Throws Error{kUsage} without Embree.
[[nodiscard]] std::vector<PeerCase> run_peers(const std::string& device_request,
                                              const PeersOptions& options,
                                              const std::function<void(const std::string&)>& note);

/// Returns rows peers/<sensor>_<n>k/..., or one text line per case.
[[nodiscard]] std::vector<Row> peer_rows(const std::vector<PeerCase>& cases);
[[nodiscard]] std::string peer_table(const std::vector<PeerCase>& cases);

/// Renders the set with the tracer, in ray order: per-ray order, exact extents, one colour per particle and
/// frame. Throws Error{kUsage} without Embree.
[[nodiscard]] RayResults traced_results(const GaussianSet& set,
                                        const SensorRays& rays,
                                        const View& view,
                                        const RenderOptions& options);

/// Returns the PSNR in dB of two pictures, clamped to [0, 1].
[[nodiscard]] double picture_psnr_db(const RayResults& a, const RayResults& b);

/// Returns absolute differences of median distances in m, ascending, for rays with a median in both.
[[nodiscard]] std::vector<double> distance_differences(const RayResults& a, const RayResults& b);

}  // namespace simuli::bench
