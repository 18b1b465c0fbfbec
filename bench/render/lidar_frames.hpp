#pragma once
// What the benches of LiDAR tiles and culling share.
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/device/render/scene/renderer.hpp"

namespace simuli::bench {

/// Says one line to whoever waits.
using Progress = std::function<void(const std::string&)>;

/// A device that records the time of every kernel.
[[nodiscard]] Device profiled_device(const std::string& request, const Progress& note);

/// `rows` beams evenly from `top` to `bottom` (degrees), `columns` firings over `span` (rad), ideal rays.
[[nodiscard]] Lidar even_lidar(int rows, int columns, double top, double bottom, double span);

struct FrameTimes {
  double frame_ms = 0.0;                   // from call to result on the device
  std::map<std::string, double> stage_ms;  // device time: rays, project, sort, bin, blend
};

/// One sensor before the bench's street, at rest, with one way to render it.
class LidarFrames {
 public:
  LidarFrames(const Device& device,
              const LidarModel& sensor,
              const ParticleBuffers& particles,
              const RenderOptions& options);

  FrameTimes run();
  /// From now on these rays alone.
  void request(const std::vector<bool>& rays) { rays_ = rays_.requested(rays); }
  [[nodiscard]] const SensorRays& rays() const { return rays_; }
  /// The last frame.
  [[nodiscard]] const Pass& pass() const { return *pass_; }

 private:
  const ParticleBuffers& particles_;
  Renderer renderer_;
  std::optional<Pass> pass_;
  SensorRays rays_;
  View view_;
};

/// The street of bench/particles/particle_street.hpp, SH degree 3, for LiDARs.
[[nodiscard]] ParticleBuffers lidar_street(const Device& device, std::int64_t particles);

}  // namespace simuli::bench
