#pragma once
// Common parts of the benches of LiDAR tiles and culling.
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/device/render/scene/renderer.hpp"

namespace simuli::bench {

/// Receives one line of progress.
using Progress = std::function<void(const std::string&)>;

/// Opens a device that records the time of each kernel.
[[nodiscard]] Device profiled_device(const std::string& request, const Progress& note);

/// Returns `rows` evenly spaced beams from `top` to `bottom` (degrees) with `columns` columns over `span`
/// (rad) and ideal rays.
[[nodiscard]] Lidar even_lidar(int rows, int columns, double top, double bottom, double span);

struct FrameTimes {
  double frame_ms = 0.0;                   // from the call to the result on the device
  std::map<std::string, double> stage_ms;  // device time: rays, project, sort, bin, blend
};

/// A resting sensor in the bench's street with one set of render options.
class LidarFrames {
 public:
  LidarFrames(const Device& device,
              const LidarModel& sensor,
              const ParticleBuffers& particles,
              const RenderOptions& options);

  FrameTimes run();
  /// Restricts later frames to these rays.
  void request(const std::vector<bool>& rays) { rays_ = rays_.requested(rays); }
  [[nodiscard]] const SensorRays& rays() const { return rays_; }
  /// Returns the last frame.
  [[nodiscard]] const Pass& pass() const { return *pass_; }

 private:
  const ParticleBuffers& particles_;
  Renderer renderer_;
  std::optional<Pass> pass_;
  SensorRays rays_;
  View view_;
};

/// Returns the street of bench/particles/particle_street.hpp for LiDARs, SH degree 3.
[[nodiscard]] ParticleBuffers lidar_street(const Device& device, std::int64_t particles);

}  // namespace simuli::bench
