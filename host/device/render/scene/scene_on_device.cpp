#include "host/device/render/scene/scene_on_device.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <list>
#include <utility>
#include <variant>
#include <vector>

#include "host/device/render/options/quality.hpp"
#include "host/device/render/options/validate.hpp"
#include "host/device/render/pages/particle_pages.hpp"
#include "host/device/render/scene/appearance_on_device.hpp"
#include "host/device/render/scene/frame_state.hpp"
#include "host/device/render/scene/ray_cache.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "host/device/render/scene/view.hpp"

namespace simuli {
namespace {

/// Key of uploaded particles, in addition to the scene.
struct UploadKey {
  SetKind kind;
  Precision precision;
  UploadOptions options;
  bool detailed;  // with levels of detail
  bool operator==(const UploadKey&) const = default;
};
/// An uploaded particle set: complete, or in pages.
struct Upload {
  UploadKey key;
  std::variant<ParticleBuffers, ParticlePages> particles;

  [[nodiscard]] const ParticleBuffers& buffers() const {
    const auto* const pages = std::get_if<ParticlePages>(&particles);
    return pages != nullptr ? pages->buffers() : std::get<ParticleBuffers>(particles);
  }
};

struct Painter {
  RenderOptions options;
  Renderer renderer;
};

/// Result of rendering a frame.
struct Drawn {
  Pass pass;
  Precision precision;
  const ParticleBuffers& particles;
  std::array<float, 3> background;
};

/// [5][rays] in ray order; missing gradients are 0.
std::vector<double> output_gradients(std::size_t rays, const RayGradients& of_rays) {
  std::vector<double> out(5 * rays, 0.0);
  const std::array<const std::vector<float>*, 5> all{&of_rays.feature[0],
                                                     &of_rays.feature[1],
                                                     &of_rays.feature[2],
                                                     &of_rays.transmittance,
                                                     &of_rays.distance};
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::vector<float>& values = *all[k];
    if (values.empty()) continue;
    if (values.size() != rays) {
      throw Error(
          ErrorKind::kUsage,
          fmt::format("gradients: found {} values, allowed one for each of {} rays", values.size(), rays));
    }
    if (!std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); })) {
      throw Error(ErrorKind::kUsage, "gradients: found a value that is not finite, allowed finite ones");
    }
    std::copy(values.begin(), values.end(), out.begin() + static_cast<std::ptrdiff_t>(k * rays));
  }
  return out;
}

/// Transposes [rows][stride] to [N, rows].
Eigen::MatrixXf by_particle(const RealBuffer& gradients, const ParticleBuffers& particles) {
  const std::vector<float> values = gradients.download_float();
  const int rows = param_rows(particles.sh_degree);
  Eigen::MatrixXf out(particles.count, rows);
  for (int row = 0; row < rows; ++row) {
    const float* const from = values.data() + static_cast<std::size_t>(row) * particles.stride;
    for (std::uint32_t i = 0; i < particles.count; ++i) out(i, row) = from[i];
  }
  return out;
}

const RenderOptions& valid(const RenderOptions& options) {
  validate(options);
  return options;
}

/// Returns the element of `kept` that suits(), else the result of make(); most recently used first, at most
/// `most`.
template <class T, class Suits, class Make>
T& first_of(std::list<T>& kept, std::size_t most, const Suits& suits, const Make& make) {
  const auto found = std::find_if(kept.begin(), kept.end(), suits);
  if (found != kept.end()) {
    kept.splice(kept.begin(), kept, found);
    return kept.front();
  }
  if (kept.size() >= most) kept.pop_back();  // before making another, to limit device memory
  make();
  return kept.front();
}

}  // namespace

struct SceneOnDevice::State {
  // Uploads for recently used options, which a viewer or a comparison switches between.
  static constexpr std::size_t kMostUploads = 4;
  static constexpr std::size_t kMostPainters = 2;

  State(const Device& on, std::shared_ptr<const Scene> of, const RenderOptions& with)
      : device(on), scene(std::move(of)), options(valid(with)), sensors(RayCache::of(on)) {}

  /// `whole`: throws an Error unless the complete set fits on the device.
  Upload& particles(SetKind kind, const RenderOptions& o, bool whole) {
    const UploadKey key{kind, o.precision, o, o.detail > 0.0};
    return first_of(
        uploads,
        kMostUploads,
        [&](const Upload& upload) { return upload.key == key && !(whole && upload.buffers().paged); },
        [&] {
          const std::shared_ptr<const GaussianSet> set(
              scene, kind == SetKind::kCamera ? &scene->camera : &scene->lidar);
          const std::uint32_t places = pages_that_fit(device, *set, o);
          if (whole || places == page_count(*set, o)) {
            uploads.push_front({key, ParticleBuffers(device, *set, o)});
          } else {
            uploads.push_front({key, ParticlePages(device, set, o, places)});
          }
        });
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

  SensorRays rays(const Sensor& sensor, const RenderOptions& o, std::vector<bool> requested) {
    const auto make = [&] {
      if (!requested.empty()) return rays(sensor, o, {}).requested(requested);
      if (sensor.is_camera()) return SensorRays(device, sensor.camera(), o);
      return SensorRays(device, sensor.lidar(), sensor.rays(), o);
    };
    return sensors->get({sensor, o.precision, o, requested}, make);
  }

  AppearanceOnDevice& appearance_on(Precision precision) {
    if (!appearance || appearance_precision != precision) {
      appearance.emplace(device, *scene, precision);
      appearance_precision = precision;
    }
    return *appearance;
  }

  /// Options of draw() in addition to the request.
  struct Drawing {
    bool actor_ids = false;  // render actor numbers
    bool whole = false;  // complete upload, for gradients
  };

  /// Renders; results stay on the device with the pass.
  Drawn draw(const Sensor& sensor, const Shot& shot, const FrameRequest& request, Drawing what) {
    RenderOptions o = request.options ? *request.options : options;
    o.camera_filter_px2 = camera_filter_px2(o, scene->camera_filter_px2);
    const SetKind kind = sensor.is_camera() ? SetKind::kCamera : SetKind::kLidar;
    View view = view_of(*scene, shot, kind);
    view.camera_median = request.camera_median;
    view.actor_ids = what.actor_ids;
    if (what.actor_ids) view.background = {};  // the median's background is 0
    if (!sensor.is_camera()) view.drop = ray_drop_of(scene->ray_drop, name_of(sensor.lidar()));
    Renderer& on = renderer(o);
    const SensorRays seen = rays(sensor, o, request.rays);
    Upload& upload = particles(kind, o, what.whole);
    const Camera* camera = sensor.is_camera() && request.graded ? &sensor.camera() : nullptr;
    Pass pass = std::visit(
        [&](auto& set) {
          return sensor.is_camera() && !what.actor_ids
                     ? appearance_on(o.precision).render(on, set, seen, view, camera, shot)
                     : on.render(set, seen, view);
        },
        upload.particles);
    return {std::move(pass), o.precision, upload.buffers(), view.background};
  }

  /// Converts a rendering to a frame.
  std::shared_ptr<Frame::State> frame_of(Drawn drawn,
                                         const Sensor& sensor,
                                         const Shot& shot,
                                         const FrameRequest& request) {
    auto frame = std::make_shared<Frame::State>(
        device, drawn.precision, sensor, shot, request, drawn.pass.rays(), pool);
    frame->scene = scene;
    frame->owner_numbers = owner_numbers(*scene);
    frame->graded = drawn.pass.is_graded();
    frame->has_median = drawn.pass.has_median();
    frame->background = drawn.background;
    drawn.pass.exchange_outputs(frame->outputs, frame->picture);
    frame->done.emplace(device);
    return frame;
  }

  Device device;
  std::shared_ptr<const Scene> scene;
  RenderOptions options;
  std::list<Upload> uploads;
  std::list<Painter> painters;
  std::shared_ptr<RayCache> sensors;  // shared by the device
  std::optional<AppearanceOnDevice> appearance;
  Precision appearance_precision = Precision::kFloat;
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
  Drawn drawn = s.draw(sensor, shot, request, {});
  const bool has_actors = drawn.particles.actors > 0;
  const auto frame = s.frame_of(std::move(drawn), sensor, shot, request);
  if (request.actors && has_actors) {
    frame->of_actors =
        Frame(s.frame_of(s.draw(sensor, shot, request, {.actor_ids = true}), sensor, shot, request));
    const SetKind kind = sensor.is_camera() ? SetKind::kCamera : SetKind::kLidar;
    frame->boxes.emplace(s.scene->actors, view_of(*s.scene, shot, kind));
  }
  return Frame(frame);
}

Eigen::MatrixXf SceneOnDevice::gradients(const Frame& frame, const RayGradients& of_rays) {
  State& s = *state_;
  const Frame::State& f = *frame.state_;
  FrameAccess::need_of(frame, *s.scene, "gradients");
  if (f.graded) {
    throw Error(ErrorKind::kUsage,
                "gradients: found a picture seen through colour grids, allowed one that is not graded");
  }
  need_gradients(f.request.options ? *f.request.options : s.options, "gradients");
  const std::vector<double> by_ray = output_gradients(f.rays.grid().rays, of_rays);
  Drawn drawn = s.draw(f.sensor, f.shot, f.request, {.whole = true});
  drawn.pass.set_output_gradients(by_ray);
  RealBuffer gradients(s.device, "gradients by particle", drawn.precision);
  drawn.pass.backward(drawn.particles, gradients);
  return by_particle(gradients, drawn.particles);
}

void SceneOnDevice::set_scene(Scene scene) { set_scene(std::make_shared<const Scene>(std::move(scene))); }

void SceneOnDevice::set_scene(std::shared_ptr<const Scene> scene) {
  state_->uploads.clear();
  state_->appearance.reset();
  state_->scene = std::move(scene);
}

const Scene& SceneOnDevice::scene() const { return *state_->scene; }
const Device& SceneOnDevice::device() const { return state_->device; }
std::size_t SceneOnDevice::sensor_count() const { return state_->sensors->size(); }

}  // namespace simuli
