#include "host/device/render/frame/variant.hpp"

#include <algorithm>

namespace simuli {

BuildOptions Variant::build_options() const {
  const bool is_camera = frame.sensor == SensorType::kCamera;
  BuildOptions out;
  out.real(options.precision)
      .define("SENSOR", frame.sensor)
      .define("LENS", frame.lens)
      .define("WINDSHIELD", frame.windshield)
      .define("DROP", !is_camera)
      .define("MOVING", frame.moving)
      .define("ORIGINS", frame.origins)
      .define("ACTORS", frame.actors)
      .define("ACTOR_MOTION", frame.actor_motion)
      .define("DEFORM", frame.deform)
      .define("DETAIL", options.detail > 0.0)
      .define("SH_DEGREE", frame.sh_degree)
      .define("SH_HALF", frame.sh_storage == ShStorage::kHalf)
      .define("MEDIAN", frame.median)
      .define("ACTOR_IDS", frame.actor_ids)
      .define("CULLING", frame.culling)
      .define("V", options.shape.lanes)
      .define("NR", options.shape.vectors)
      .define("LS", options.shape.work_items)
      // Clamps colours at 0 in all three channels; for LiDARs only the intensity.
      .define("CLAMPED_CHANNELS", is_camera ? 3 : 1)
      .define("PROJECTION", options.projection)
      .define("EXTENT", options.extent)
      .define("RAY_ORDER", options.order != Order::kRange)
      .define("PER_RAY", options.order == Order::kPerRay)
      .define("WINDOW", options.window)
      // Without bands above 0 a particle's features do not depend on direction.
      .define("RAY_SH", options.sh_direction == ShDirection::kRay && frame.sh_degree > 0)
      .define("SHUTTER_ITERATIONS", std::max(options.shutter_iterations, 1))
      .define("COMPENSATION", is_camera ? options.camera_compensation : options.lidar_compensation);
  return out;
}

}  // namespace simuli
