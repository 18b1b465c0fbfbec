#include "host/device/render/scene/renderer.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/device/render/frame/actor_constants.hpp"
#include "host/device/render/options/lane_shape.hpp"
#include "host/device/render/options/validate.hpp"
#include "host/device/render/pages/particle_pages.hpp"
#include "host/device/render/scene/pass_state.hpp"
#include "host/device/render/scene/sensor_in_frame.hpp"

namespace simuli {
namespace {

RenderOptions resolve(const Device& device, RenderOptions options) {
  validate(options);
  options.camera_filter_px2 = camera_filter_px2(options);
  if (options.shape.lanes == 0) options.shape = lane_shape_of(device, options.precision);
  const LaneShape& s = options.shape;
  if (s.lanes * s.vectors * s.work_items != SIM_TILE_RAYS) {
    throw Error(ErrorKind::kInternal, "lane shape: lanes x vectors x work-items is not 256");
  }
  const std::size_t most = device.info().max_work_group_size;
  if (static_cast<std::size_t>(s.work_items) > most) {
    throw Error(ErrorKind::kDevice,
                fmt::format("lane shape: found {} work-items, the device allows {}", s.work_items, most));
  }
  return options;
}

FrameKind kind_of(const RenderOptions& options,
                  const ParticleBuffers& particles,
                  const SensorRays& rays,
                  const View& view,
                  bool moving,
                  bool actor_motion,
                  bool deform) {
  const RayGrid& grid = rays.grid();
  FrameKind kind;
  kind.actors = particles.actors > 0;
  kind.actor_motion = actor_motion;
  kind.deform = deform;
  kind.sensor = grid.type;
  kind.lens = grid.lens;
  kind.windshield = grid.windshield;
  kind.moving = moving;
  kind.origins = moving || grid.lever_arms;
  kind.sh_degree = std::min(particles.sh_degree, options.sh_degree);
  kind.sh_storage = particles.sh_storage;
  kind.actor_ids = view.actor_ids;
  kind.median =
      view.actor_ids || (grid.type == SensorType::kLidar ? options.median_distance : view.camera_median);
  kind.culling = rays.can_cull();
  return kind;
}

void check(const RenderOptions& options,
           const ParticleBuffers& particles,
           const SensorRays& rays,
           const View& view,
           const EnvironmentBuffers* environment) {
  const auto need = [](bool holds, const std::string& found, const std::string& allowed) {
    if (!holds) throw Error(ErrorKind::kUsage, "render: found " + found + ", allowed " + allowed);
  };
  rays.need_made_with(options);
  need(particles.params.precision() == options.precision,
       "particles of the other precision",
       "the renderer's");
  need(particles.actors <= view.actors.size(),
       fmt::format("a view of {} actors", view.actors.size()),
       fmt::format("the {} that particles belong to", particles.actors));
  need(!view.actor_ids || particles.actors > 0, "actors of particles without any", "particles of actors");
  if (environment == nullptr) return;
  need(rays.grid().type == SensorType::kCamera, "an environment behind a LiDAR", "one behind a camera");
  need(environment->texture.precision() == options.precision,
       "an environment of the other precision",
       "the renderer's");
}

/// Freezes all actors at mid-frame.
std::vector<ActorView> at_rest(std::vector<ActorView> actors) {
  for (ActorView& actor : actors) {
    actor.scene_from_actor_start = interpolate(actor.scene_from_actor_start, actor.scene_from_actor_end, 0.5);
    actor.scene_from_actor_end = actor.scene_from_actor_start;
    DeformationView& shape = actor.deformation;
    shape.start_m = shape.at(0.5);
    shape.end_m = shape.start_m;
  }
  return actors;
}

}  // namespace

Pass::State::State(const Device& on, const RenderOptions& wanted)
    : device(on),
      options(resolve(on, wanted)),
      bin(on),
      image_loss(on, wanted.precision),
      lidar_loss(on, wanted.precision),
      buffers(on, wanted.precision),
      gradients(on, wanted.precision),
      actors(on, wanted.precision),
      pictures(on, wanted.precision) {}

Pass::State::Stages& Pass::State::stages(const FrameKind& kind) {
  auto& entry = all_stages[kind];
  if (!entry) entry = std::make_unique<Stages>(device, Variant{kind, options});
  return *entry;
}

Pass::State::ColorGrid& Pass::State::grid_stages(const ColorGridBuffers& of) {
  const std::array<int, 3> size{of.size_x, of.size_y, of.size_z};
  const auto found = grids.find(size);
  if (found != grids.end()) return found->second;
  return grids.emplace(size, ColorGrid{ColorGridStage(device, of), {}}).first->second;
}

Renderer::Renderer(const Device& device, const RenderOptions& options)
    : state_(std::make_shared<Pass::State>(device, options)) {}

const RenderOptions& Renderer::options() const { return state_->options; }
const Device& Renderer::device() const { return state_->device; }

void Renderer::confine(ParticleBuffers& particles, const std::vector<Actor>& actors, double margin_m) {
  state_->actors.confine(particles, actors, margin_m);
}

Pass Renderer::render(const ParticleBuffers& particles,
                      const SensorRays& rays,
                      const View& view,
                      const EnvironmentBuffers* environment) {
  return render(particles, nullptr, rays, view, environment);
}

Pass Renderer::render(ParticlePages& particles,
                      const SensorRays& rays,
                      const View& view,
                      const EnvironmentBuffers* environment) {
  return render(particles.buffers(), &particles, rays, view, environment);
}

Pass Renderer::render(const ParticleBuffers& particles,
                      ParticlePages* pages,
                      const SensorRays& rays,
                      const View& view,
                      const EnvironmentBuffers* environment) {
  Pass::State& s = *state_;
  check(s.options, particles, rays, view, environment);
  const bool still = s.options.shutter_iterations == 0;
  const Pose middle = interpolate(view.scene_from_sensor_start, view.scene_from_sensor_end, 0.5);
  SensorInFrame sensor = sensor_in_frame(rays,
                                         still ? middle : view.scene_from_sensor_start,
                                         still ? middle : view.scene_from_sensor_end,
                                         s.options,
                                         environment == nullptr ? view.background : std::array<float, 3>{},
                                         view.drop);
  bool actor_motion = false;
  std::vector<double> actors;
  ShapesInFrame shapes;
  if (particles.actors > 0) {
    const std::vector<ActorView> views = still ? at_rest(view.actors) : view.actors;
    actors = actor_constants(views, Eigen::Vector3d(sensor.constants.centre_ref), actor_motion);
    shapes = shapes_in_frame(views,
                             rays.grid(),
                             still ? middle : view.scene_from_sensor_start,
                             still ? middle : view.scene_from_sensor_end);
  }
  Pass::State::Stages& stages = s.stages(kind_of(
      s.options, particles, rays, view, sensor.moving || actor_motion, actor_motion, !shapes.empty()));

  if (pages != nullptr) {
    pages->bring(FrameSight(rays.grid().type, sensor.constants, s.options.detail > 0.0, actors));
  }

  // From here on the last frame's buffers are overwritten.
  const std::uint64_t number = ++s.frames;
  s.frame = {
      rays, &stages, rays.grid().frame, sensor.constants, view.background, particles.id(), environment};
  s.frame.paged = particles.paged;
  s.frame.params.particles = particles.in_frame();
  s.frame.params.stride = particles.stride;
  const shared::FrameParams& frame = s.frame.params;
  FrameBuffers& b = s.buffers;
  const RayBuffers on_device = rays.buffers();
  if (particles.actors > 0) b.constants.actors.assign(actors);
  b.constants.sensor.assign(shared::reals_of(sensor.constants));
  if (!shapes.empty()) {
    b.constants.deform_at.assign(shapes.at);
    b.constants.deform_shapes.assign(shapes.reals);
    if (!s.deform) s.deform.emplace(s.device, s.options.precision);
    s.deform->run(particles, b.constants);
  }
  s.frame.shapes = std::move(shapes);
  stages.rays.run(frame, on_device, b.constants, b.rays);
  stages.project.run(frame, particles, on_device, b.constants, b.projected);
  s.bin.run(frame, particles, on_device, b.projected, s.options.max_pairs, b.binned);
  stages.render.run(frame, particles, on_device, b.constants, b.rays, b.projected, b.binned, b.blended);
  if (environment != nullptr) {
    if (!s.environment) s.environment.emplace(s.device, s.options.precision, s.options.shape.lanes);
    s.environment->run(frame, *environment, b.constants, b.rays, b.blended);
  }
  return {state_, number};
}

}  // namespace simuli
