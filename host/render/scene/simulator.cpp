#include "host/render/scene/simulator.hpp"

#include <deque>
#include <optional>
#include <utility>
#include <variant>

#include "host/base/error.hpp"
#include "host/render/options/validate.hpp"
#include "host/render/scene/look.hpp"
#include "host/render/scene/renderer.hpp"

namespace simuli {
namespace {

/// Everything of a sensor that its rays depend on: equal numbers, equal rays.
using SensorKey = std::vector<double>;

SensorKey key_of(const Camera& c) {
  SensorKey key{0.0,
                static_cast<double>(c.width),
                static_cast<double>(c.height),
                c.fx,
                c.fy,
                c.cx,
                c.cy,
                static_cast<double>(c.shutter),
                static_cast<double>(c.lens.kind())};
  const std::vector<double>& lens = c.lens.parameters();
  key.insert(key.end(), lens.begin(), lens.end());
  return key;
}

void append(SensorKey& key, const Lidar& l) {
  key.insert(key.end(),
             {1.0,
              static_cast<double>(l.columns),
              l.azimuth_first,
              l.azimuth_span,
              l.spin_sign(),
              static_cast<double>(l.rows.size())});
  for (const LidarRow& r : l.rows) {
    key.insert(key.end(),
               {r.elevation,
                r.azimuth_offset,
                r.vertical_offset,
                r.horizontal_offset,
                r.time_offset,
                r.radial_offset,
                r.range_bias});
  }
  for (const BlindArc& arc : l.blind) {
    key.insert(key.end(), {static_cast<double>(arc.row), arc.azimuth_first, arc.azimuth_last});
  }
}

void append(SensorKey& key, const RayList& l) {
  key.push_back(2.0);
  for (const auto* values : {&l.azimuth, &l.elevation, &l.time_fraction}) {
    key.insert(key.end(), values->begin(), values->end());
  }
  for (const Eigen::Vector3d& p : l.origin) key.insert(key.end(), {p.x(), p.y(), p.z()});
}

SensorKey key_of(const LidarModel& lidar, double duration_s) {
  SensorKey key{duration_s};
  std::visit(
      [&key](const auto& model) {
        key.insert(key.end(),
                   {model.range_min, model.range_max, model.beam_divergence, model.divergence_variance});
        append(key, model);
      },
      lidar);
  return key;
}

struct KnownSensor {
  SensorKey key;
  SensorRays rays;
  LidarRays fired;  // of a LiDAR
};

const RenderOptions& valid(const RenderOptions& options) {
  validate(options);
  return options;
}

}  // namespace

Shot Shot::at(const Pose& world_from_sensor, double time_s, double duration_s) {
  return {world_from_sensor, world_from_sensor, time_s, time_s + duration_s};
}

Shot Shot::along(const Trajectory& world_from_rig,
                 const Pose& rig_from_sensor,
                 double time_start_s,
                 double time_end_s) {
  return {world_from_rig.at(time_start_s) * rig_from_sensor,
          world_from_rig.at(time_end_s) * rig_from_sensor,
          time_start_s,
          time_end_s};
}

struct Simulator::State {
  State(const Device& device, Scene of, const RenderOptions& options)
      : scene(std::move(of)),
        renderer(device, valid(options)),
        look(device, scene, renderer.options().precision) {}

  [[nodiscard]] const ParticleBuffers& particles(SetKind kind) {
    std::optional<ParticleBuffers>& set = kind == SetKind::kCamera ? camera_set : lidar_set;
    if (!set) {
      set.emplace(
          renderer.device(), kind == SetKind::kCamera ? scene.camera : scene.lidar, renderer.options());
    }
    return *set;
  }

  /// The sensor with that key, made by make() when it is not one of the last kMost.
  template <class Make>
  [[nodiscard]] const KnownSensor& sensor(const SensorKey& key, const Make& make) {
    constexpr std::size_t kMost = 8;
    for (const KnownSensor& known : sensors) {
      if (known.key == key) return known;
    }
    if (sensors.size() == kMost) sensors.pop_front();
    sensors.push_back(make());
    return sensors.back();
  }

  [[nodiscard]] View view(const Shot& shot, SetKind kind) const {
    View view{shot.world_from_sensor_start,
              shot.world_from_sensor_end,
              kind == SetKind::kCamera ? scene.camera_background : scene.lidar_background,
              actors_during(scene.actors, shot.time_start_s, shot.time_end_s, scene.origin)};
    view.scene_from_sensor_start.translation -= scene.origin;
    view.scene_from_sensor_end.translation -= scene.origin;
    return view;
  }

  Scene scene;
  Renderer renderer;
  std::optional<Pass> pass;  // the last
  SceneLook look;
  std::optional<ParticleBuffers> camera_set, lidar_set;
  std::deque<KnownSensor> sensors;
};

Simulator::Simulator(const Device& device, Scene scene, const RenderOptions& options)
    : state_(std::make_unique<State>(device, std::move(scene), options)) {}
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;
Simulator::~Simulator() = default;

Image Simulator::render(const Camera& camera, const Shot& shot) {
  State& s = *state_;
  SensorKey key = key_of(camera);
  const KnownSensor& known = s.sensor(key, [&] {
    validate(camera, "camera " + camera.name);
    return KnownSensor{std::move(key), {s.renderer.device(), camera, s.renderer.options()}, {}};
  });
  const double middle_s = 0.5 * (shot.time_start_s + shot.time_end_s);
  s.pass = s.look.render(s.renderer,
                         s.particles(SetKind::kCamera),
                         known.rays,
                         s.view(shot, SetKind::kCamera),
                         camera.name,
                         middle_s);
  return picture_of(s.pass->results(), camera);
}

LidarFrame Simulator::render(const LidarModel& lidar, const Shot& shot) {
  State& s = *state_;
  const double duration_s = shot.time_end_s - shot.time_start_s;  // the beams' firing times are shares of it
  SensorKey key = key_of(lidar, duration_s);
  const KnownSensor& known = s.sensor(key, [&] {
    validate(lidar, "LiDAR " + name_of(lidar));
    LidarRays fired = nominal_rays(lidar, duration_s);
    SensorRays rays(s.renderer.device(), lidar, fired, s.renderer.options());
    return KnownSensor{std::move(key), std::move(rays), std::move(fired)};
  });
  s.pass = s.renderer.render(s.particles(SetKind::kLidar), known.rays, s.view(shot, SetKind::kLidar));
  return lidar_frame(lidar, known.fired, s.pass->results());
}

const Scene& Simulator::scene() const { return state_->scene; }
const Device& Simulator::device() const { return state_->renderer.device(); }

const Pass& Simulator::pass() const {
  if (!state_->pass) throw Error(ErrorKind::kUsage, "pass: found no frame, allowed after render()");
  return *state_->pass;
}

std::vector<Eigen::Vector3d> world_points(const LidarModel& lidar,
                                          const LidarFrame& frame,
                                          const Shot& shot) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < frame.range.size(); ++i) {
    const Pose world_from_lidar =
        interpolate(shot.world_from_sensor_start, shot.world_from_sensor_end, frame.rays.time_fraction[i]);
    points.push_back(world_from_lidar *
                     (ray_origin(lidar, frame.rays, i) +
                      static_cast<double>(frame.range[i]) *
                          Lidar::direction(frame.rays.azimuth[i], frame.rays.elevation[i])));
  }
  return points;
}

}  // namespace simuli
