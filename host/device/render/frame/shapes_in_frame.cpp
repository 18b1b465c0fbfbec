#include "host/device/render/frame/shapes_in_frame.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace simuli {
namespace {

constexpr std::uint32_t kNone = 0xffffffffU;

/// Share of the frame at which the sensor observes p (m, sensor frame). Cameras are treated as pinholes,
/// because shutters are slow compared to distortion.
double seen_at(const RayGrid& grid, const Eigen::Vector3d& p) {
  const shared::ModelConstants<double>& model = grid.model;
  double share = 0.5;
  if (grid.type == SensorType::kLidar) {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    const double x = (std::atan2(p.y(), p.x()) - model.azimuth_cut) * model.spin;
    share = model.time_first + (x - kTurn * std::floor(x / kTurn)) * model.inv_span;
  } else if (p.z() > 0.0) {
    const double x = std::clamp(model.fx * p.x() / p.z() + model.cx, 0.0, model.picture_width);
    const double y = std::clamp(model.fy * p.y() / p.z() + model.cy, 0.0, model.picture_height);
    share = model.time_c + model.time_x * x + model.time_y * y;
  }
  return std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 0.5;
}

}  // namespace

ShapesInFrame shapes_in_frame(const std::vector<ActorView>& actors,
                              const RayGrid& grid,
                              const Pose& scene_from_sensor_start,
                              const Pose& scene_from_sensor_end) {
  ShapesInFrame out;
  const auto is_rigid = [](const ActorView& a) { return !a.is_there || a.deformation.empty(); };
  if (std::all_of(actors.begin(), actors.end(), is_rigid)) return out;
  out.at.assign(actors.size() + 1, kNone);
  out.share.assign(actors.size(), 0.5);
  for (std::size_t i = 0; i < actors.size(); ++i) {
    const ActorView& actor = actors[i];
    if (is_rigid(actor)) continue;
    double share = 0.5;
    constexpr int kLooks = 3;  // iterations; the sensor and the actor both move little between them
    for (int k = 0; k < kLooks; ++k) {
      const Pose sensor = interpolate(scene_from_sensor_start, scene_from_sensor_end, share);
      share = seen_at(
          grid,
          sensor.inverse() *
              interpolate(actor.scene_from_actor_start, actor.scene_from_actor_end, share).translation);
    }
    out.share[i] = share;
    out.at[i + 1] = static_cast<std::uint32_t>(out.reals.size());
    const DeformationView& shape = actor.deformation;
    out.reals.insert(out.reals.end(), shape.half_m.begin(), shape.half_m.end());
    out.reals.insert(out.reals.end(), shape.nodes.begin(), shape.nodes.end());
    const std::vector<double> offsets_m = shape.at(share);
    out.reals.insert(out.reals.end(), offsets_m.begin(), offsets_m.end());
  }
  return out;
}

}  // namespace simuli
