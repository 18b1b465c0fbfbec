#include "optim/eval/sweep_pair.hpp"

#include <cmath>

#include "host/device/render/scene/readings.hpp"
#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"

namespace simuli {

bool is_met(const SweepPair& pair, std::size_t ray) {
  const RayResults& r = pair.simulated;
  return r.drop_probability(ray) < 0.5F &&
         std::abs(best_distance(r, ray) - pair.recorded.range[ray]) < SweepPair::kSame_m;
}

SweepPair render_sweep(SceneOnDevice& scene, const Log& log, const SweepFrame& frame) {
  const LidarModel& lidar = log.lidar(frame.lidar).model;
  SweepPair pair;
  pair.recorded = read_sweep(log, frame, lidar);
  const Sensor sensor = Sensor(lidar).with_rays(pair.recorded.rays);
  pair.simulated = scene.render(sensor, shot_of(log, frame)).results();
  return pair;
}

}  // namespace simuli
