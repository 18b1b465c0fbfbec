#include "host/render/scene/scene_on_device.hpp"

#include <algorithm>
#include <list>
#include <utility>
#include <vector>

#include "host/base/lru_cache.hpp"
#include "host/render/options/validate.hpp"
#include "host/render/scene/frame_state.hpp"
#include "host/render/scene/look.hpp"
#include "host/render/scene/renderer.hpp"
#include "host/render/scene/view.hpp"

namespace simuli {
namespace {

/// A particle set with what is kept of it.
struct Upload {
  SetKind kind;
  RenderOptions options;
  ParticleBuffers particles;

  [[nodiscard]] bool suits(SetKind of, const RenderOptions& o) const {
    return of == kind && o.precision == options.precision && o.sh_degree == options.sh_degree &&
           o.sh_storage == options.sh_storage &&
           (o.sh_degree != ShDegree::kAuto || o.sh_error == options.sh_error);
  }
};

/// What the rays of a sensor on the device depend on.
struct RaysKey {
  Sensor sensor;
  RenderOptions options;
  bool operator==(const RaysKey& other) const {
    return sensor.has_rays_of(other.sensor) && options == other.options;
  }
};
struct RaysHash {
  std::size_t operator()(const RaysKey& key) const { return key.sensor.rays_hash(); }
};

struct Painter {
  RenderOptions options;
  Renderer renderer;
};

const RenderOptions& valid(const RenderOptions& options) {
  validate(options);
  return options;
}

/// The one of `kept` that suits(), else what make() puts in front; the last used first, at most `most`.
template <class T, class Suits, class Make>
T& first_of(std::list<T>& kept, std::size_t most, const Suits& suits, const Make& make) {
  const auto found = std::find_if(kept.begin(), kept.end(), suits);
  if (found != kept.end()) {
    kept.splice(kept.begin(), kept, found);
    return kept.front();
  }
  if (kept.size() >= most) kept.pop_back();  // first, so that the device never holds more
  make();
  return kept.front();
}

}  // namespace

struct SceneOnDevice::State {
  // Of the options used last: what a viewer switches between, and a comparison of two.
  static constexpr std::size_t kMostUploads = 4;
  static constexpr std::size_t kMostPainters = 2;

  State(const Device& on, std::shared_ptr<const Scene> of, const RenderOptions& with)
      : device(on),
        scene(std::move(of)),
        options(valid(with)),
        sensors(static_cast<std::size_t>(on.info().global_bytes / 4)) {}

  const ParticleBuffers& particles(SetKind kind, const RenderOptions& o) {
    return first_of(
               uploads,
               kMostUploads,
               [&](const Upload& upload) { return upload.suits(kind, o); },
               [&] {
                 const GaussianSet& set = kind == SetKind::kCamera ? scene->camera : scene->lidar;
                 uploads.push_front({kind, o, ParticleBuffers(device, set, o)});
               })
        .particles;
  }

  Renderer& renderer(const RenderOptions& o) {
    return first_of(
               painters,
               kMostPainters,
               [&](const Painter& painter) { return painter.options == o; },
               [&] {
                 painters.push_front({o, Renderer(device, o)});
               })
        .renderer;
  }

  SensorRays rays(const Sensor& sensor, const Renderer& renderer, const RenderOptions& o) {
    const auto make = [&] {
      const RenderOptions& resolved = renderer.options();
      if (sensor.is_camera()) return SensorRays(device, sensor.camera(), resolved);
      return SensorRays(device, sensor.lidar(), sensor.rays(), resolved);
    };
    return *sensors.get({sensor, o}, make, [](const SensorRays& made) { return made.bytes(); });
  }

  SceneLook& look_of(Precision precision) {
    if (!look || look_precision != precision) {
      look.emplace(device, *scene, precision);
      look_precision = precision;
    }
    return *look;
  }

  Device device;
  std::shared_ptr<const Scene> scene;
  RenderOptions options;
  std::list<Upload> uploads;
  std::list<Painter> painters;
  LruCache<SensorRays, RaysKey, RaysHash> sensors;
  std::optional<SceneLook> look;
  Precision look_precision = Precision::kFloat;
  std::shared_ptr<OutputPool> pool = std::make_shared<OutputPool>();
};

SceneOnDevice::SceneOnDevice(const Device& device, Scene scene, const RenderOptions& options)
    : SceneOnDevice(device, std::make_shared<const Scene>(std::move(scene)), options) {}
SceneOnDevice::SceneOnDevice(const Device& device,
                             std::shared_ptr<const Scene> scene,
                             const RenderOptions& options)
    : state_(std::make_unique<State>(device, std::move(scene), options)) {}
SceneOnDevice::SceneOnDevice(SceneOnDevice&&) noexcept = default;
SceneOnDevice& SceneOnDevice::operator=(SceneOnDevice&&) noexcept = default;
SceneOnDevice::~SceneOnDevice() = default;

Frame SceneOnDevice::render(const Sensor& sensor, const Shot& shot, const FrameRequest& request) {
  State& s = *state_;
  const RenderOptions& options = request.options ? *request.options : s.options;
  const SetKind kind = sensor.is_camera() ? SetKind::kCamera : SetKind::kLidar;
  const View view = view_of(*s.scene, shot, kind);
  Renderer& renderer = s.renderer(options);
  SensorRays rays = s.rays(sensor, renderer, options);
  rays.request(request.rays);
  const ParticleBuffers& particles = s.particles(kind, options);
  auto frame = std::make_shared<Frame::State>(s.device, options.precision, sensor, shot, rays, s.pool);
  const std::string camera = sensor.is_camera() && request.graded ? sensor.camera().name : std::string();
  Pass pass =
      sensor.is_camera()
          ? s.look_of(options.precision).render(renderer, particles, rays, view, camera, shot.middle_s())
          : renderer.render(particles, rays, view);
  frame->graded = pass.is_graded();
  frame->has_median = pass.has_median();
  frame->background = view.background;
  pass.exchange_outputs(frame->outputs, frame->picture);
  frame->done.emplace(s.device);
  return Frame(std::move(frame));
}

void SceneOnDevice::set_scene(Scene scene) { set_scene(std::make_shared<const Scene>(std::move(scene))); }

void SceneOnDevice::set_scene(std::shared_ptr<const Scene> scene) {
  state_->uploads.clear();
  state_->look.reset();
  state_->scene = std::move(scene);
}

const Scene& SceneOnDevice::scene() const { return *state_->scene; }
const Device& SceneOnDevice::device() const { return state_->device; }
const RenderOptions& SceneOnDevice::options() const { return state_->options; }
std::size_t SceneOnDevice::sensor_count() const { return state_->sensors.size(); }

}  // namespace simuli
