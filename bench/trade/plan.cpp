#include "bench/trade/plan.hpp"

#include <array>
#include <fmt/format.h>
#include <memory>
#include <utility>

#include "bench/particles/particle_street.hpp"
#include "bench/render/scene.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "host/device/render/scene/scene_on_device.hpp"

namespace simuli::bench {
namespace {

/// A frame for repeated renders.
struct Setup {
  Scene scene;
  bool is_camera = true;
  Camera camera = bench_camera();
  Lidar lidar = builtin_lidar("generic64");
  RenderOptions options;
  Shot shot{world_from_bench_camera(), world_from_bench_camera()};
};

class FrameOf {
 public:
  FrameOf(const Device& device, const Setup& setup)
      : before_(device.memory().now),
        sensor_(setup.is_camera ? Sensor(setup.camera) : Sensor(setup.lidar)),
        shot_(setup.shot),
        scene_(device, setup.scene, setup.options) {
    scene_.render(sensor_, shot_).wait();
    memory_ = device.memory().now - before_;
  }
  FrameOf(const FrameOf&) = delete;
  FrameOf& operator=(const FrameOf&) = delete;

  double frame_ms() {
    return time_ms([&] { scene_.render(sensor_, shot_).wait(); });
  }
  [[nodiscard]] double memory_mb() const { return static_cast<double>(memory_) / 1e6; }

 private:
  std::uint64_t before_, memory_ = 0;
  Sensor sensor_;
  Shot shot_;
  SceneOnDevice scene_;
};

struct Part {
  std::string name;
  std::array<Setup, 3> ways;  // present, absent, never
};
constexpr std::array kWays{"present", "absent", "never"};

std::vector<Part> all_parts(std::int64_t count) {
  Setup camera;
  camera.scene.camera = street_particles(SetKind::kCamera, 3, count, 1);
  Setup lidar;
  lidar.is_camera = false;
  lidar.scene.lidar = street_particles(SetKind::kLidar, 3, count, 1);
  lidar.scene.lidar_background = {0.0F, 0.0F, 0.0F};
  lidar.shot = {world_from_street_lidar(), world_from_street_lidar()};

  std::vector<Part> parts;
  const auto add = [&parts](const std::string& name, const Setup& base) -> Part& {
    parts.push_back({name, {base, base, base}});
    return parts.back();
  };
  {
    Part& p = add("shutter", camera);
    p.ways[0].camera.shutter = p.ways[1].camera.shutter = ShutterKind::kTopToBottom;
    p.ways[0].shot.world_from_sensor_end.translation.x() += 0.3;  // 15 m/s, 20 ms
  }
  {
    Part& p = add("sweep_motion", lidar);
    p.ways[0].shot.world_from_sensor_end.translation.x() += 1.5;
  }
  {
    Part& p = add("actors", camera);
    // The actor moves 2 m/s during a frame of 0.1 s.
    KeyPose start, end;
    end.time_s = 0.1;
    end.world_from_actor.translation.x() += 0.2;
    const Actor driving{"car", "car", Eigen::Vector3d::Ones(), {start, end}};
    p.ways[0].scene.actors = p.ways[1].scene.actors = {driving};
    p.ways[0].shot.time_end_s = p.ways[1].shot.time_end_s = 0.1;
    std::vector<std::uint32_t>& actor = p.ways[0].scene.camera.actor;
    actor.assign(static_cast<std::size_t>(count), 0);
    for (std::size_t i = 0; i < actor.size(); i += 10) actor[i] = 1;
    p.ways[1].scene.camera.actor.assign(static_cast<std::size_t>(count), 0);
  }
  {
    Part& p = add("environment", camera);
    p.ways[0].scene.environment = {512, 256, std::vector<float>(std::size_t{512} * 256 * 3, 0.5F)};
  }
  {
    Part& p = add("colour_grid", camera);
    p.ways[0].scene.color_grids = ColorGrids::identity(16, 16, 8, {{p.ways[0].camera.name, 0.0}});
  }
  {
    Part& p = add("sh_degree_3", camera);
    p.ways[1].options.sh_degree = 0;
    p.ways[2].scene.camera = GaussianSet(SetKind::kCamera, 0, count);
    p.ways[2].scene.camera.params = camera.scene.camera.params.leftCols(param_rows(0));
  }
  {
    Part& p = add("beam_filter", lidar);
    p.ways[0].lidar.beam_divergence = 3e-3;
    p.ways[1].lidar.beam_divergence = 0.0;
    p.ways[2].lidar.beam_divergence = Lidar{}.beam_divergence;
  }
  {
    Part& p = add("median_distance", lidar);
    p.ways[1].options.median_distance = false;
    p.ways[2] = p.ways[1];
  }
  return parts;
}

}  // namespace

std::vector<Row> run_plan(const std::string& device_request, const PlanOptions& options, const Note& note) {
  const Device device = Device::best(device_request);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  std::vector<Row> rows;
  for (const Part& part : all_parts(options.particles)) {
    std::array<std::unique_ptr<FrameOf>, kWays.size()> frames;
    for (std::size_t way = 0; way < kWays.size(); ++way) {
      frames[way] = std::make_unique<FrameOf>(device, part.ways[way]);
    }
    std::array<std::vector<double>, kWays.size()> ms, ratios;
    for (int i = 0; i < options.repeats; ++i) {
      for (std::size_t way = 0; way < kWays.size(); ++way) ms[way].push_back(frames[way]->frame_ms());
      for (std::size_t way = 0; way < kWays.size(); ++way)
        ratios[way].push_back(ms[way].back() / ms[2].back());
    }
    for (std::size_t way = 0; way < kWays.size(); ++way) {
      const std::string base = fmt::format("plan/{}/{}/", part.name, kWays[way]);
      const Spread frame = spread_of(ms[way]), ratio = spread_of(ratios[way]);
      rows.push_back({base + "frame", frame.median, "ms", frame.half_iqr});
      if (way < 2) rows.push_back({base + "over_never", ratio.median, "x", ratio.half_iqr});
      rows.push_back({base + "memory", frames[way]->memory_mb(), "MB", 0.0});
    }
    note(part.name);
  }
  return rows;
}

}  // namespace simuli::bench
