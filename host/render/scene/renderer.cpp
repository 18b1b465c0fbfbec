#include "host/render/scene/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <numbers>
#include <utility>
#include <variant>

#include "host/base/error.hpp"
#include "host/render/frame/actor_constants.hpp"
#include "host/render/frame/room.hpp"
#include "host/render/options/lane_shape.hpp"
#include "host/render/options/quality.hpp"
#include "host/render/options/validate.hpp"
#include "host/render/rays/ray_mask.hpp"
#include "host/render/scene/renderer_stages.hpp"
#include "host/render/scene/slot_results.hpp"

namespace simuli {
namespace {

/// Some of the rays leave cells of the default size full that hold one of many: a row per beam and two
/// columns per firing instead. A size that was asked for is kept.
RayMaskSize of_some_rays(RayMaskSize size, const RayGrid& grid) {
  constexpr RayMaskSize kDefault;
  constexpr int kMostCells = 1 << 20, kMostRows = 4096;
  if (size.columns != kDefault.columns || size.rows != kDefault.rows) return size;
  const auto firings = static_cast<int>(grid.rays / grid.frame.rows);
  size.rows = std::clamp(static_cast<int>(grid.frame.rows), kDefault.rows, kMostRows);
  size.columns =
      std::clamp(2 * firings, kDefault.columns, std::max(kMostCells / size.rows, kDefault.columns));
  return size;
}

}  // namespace

SensorRays::State::State(const Device& on, RayGrid rays, const RenderOptions& options)
    : device(on),
      precision(options.precision),
      marks(rays.type == SensorType::kLidar && options.culling != Culling::kOff),
      mask_size(options.ray_mask),
      grid(std::move(rays)),
      buffers(on, grid, options.precision) {
  mark_rays(mask_size);
}

void SensorRays::State::mark_rays(RayMaskSize size) {
  if (marks) can_cull = RayMaskStage(device, precision).run(grid, size, buffers);
}

SensorRays::SensorRays(const Device& device, RayGrid grid, const RenderOptions& options)
    : state_(std::make_shared<State>(device, std::move(grid), options)) {}
SensorRays::SensorRays(const Device& device, const Camera& camera, const RenderOptions& options)
    : SensorRays(device, make_ray_grid(with_room_on(device, camera, options), options), options) {}
SensorRays::SensorRays(const Device& device,
                       const LidarModel& model,
                       const LidarRays& rays,
                       const RenderOptions& options)
    : SensorRays(device, make_ray_grid(device, model, rays, options), options) {
  if (std::holds_alternative<RayList>(model)) return;
  const auto& lidar = std::get<Lidar>(model);
  if (lidar.blind.empty()) return;
  State& s = *state_;
  s.blind.resize(s.grid.rays);
  for (std::size_t i = 0; i < s.grid.rays; ++i) {
    const auto row = static_cast<int>(i / static_cast<std::size_t>(rays.columns));
    s.blind[i] = is_blind(lidar, row, static_cast<double>(rays.azimuth[i]));
  }
  s.place_requested();
}

void SensorRays::request(const std::vector<bool>& requested) {
  State& s = *state_;
  if (!requested.empty() && requested.size() != s.grid.rays) {
    throw Error(ErrorKind::kInternal, "request: one flag per ray is needed");
  }
  if (requested == s.requested) return;
  s.requested = requested;
  s.place_requested();
}

void SensorRays::State::place_requested() {
  std::vector<float> sensor_ray = grid.sensor_ray;
  const std::size_t slots = grid.frame.slots;
  bool all = true;
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const std::int32_t of_slot = grid.ray_of_slot[slot];
    const auto ray = static_cast<std::size_t>(of_slot);
    const bool is_wanted =
        of_slot < 0 || ((requested.empty() || requested[ray]) && (blind.empty() || !blind[ray]));
    if (is_wanted) continue;
    all = false;
    for (std::size_t k = 0; k < 3; ++k) sensor_ray[k * slots + slot] = 0.0F;
  }
  buffers.sensor_ray.assign(sensor_ray);
  mark_rays(all ? mask_size : of_some_rays(mask_size, grid));
}

RayMap::RayMap(const Device& device, const RayGrid& grid) : BufferTable(device) {
  ray_of_slot.assign(grid.ray_of_slot);
  std::vector<std::int32_t> slots(grid.rays, -1);
  for (std::size_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
    const std::int32_t ray = grid.ray_of_slot[slot];
    if (ray >= 0) slots[static_cast<std::size_t>(ray)] = static_cast<std::int32_t>(slot);
  }
  slot_of_ray.assign(slots);
}

const RayMap& SensorRays::map() const {
  if (!state_->map) state_->map.emplace(state_->device, state_->grid);
  return *state_->map;
}

std::size_t SensorRays::bytes() const {
  const RayBuffers& b = state_->buffers;
  const std::size_t real = state_->precision == Precision::kFloat ? sizeof(float) : sizeof(double);
  return real * (b.sensor_ray.capacity() + b.u.capacity() + b.row_elevation.capacity()) + b.row_lut.bytes() +
         b.tile_rows.bytes() + b.tile_row_of_row.bytes() + b.column_of_bin.bytes() +
         b.mask_row_of_row.bytes() + b.areas.bytes();
}

std::vector<float> SensorRays::to_slots(const std::vector<float>& values, std::size_t channels) const {
  const RayGrid& grid = state_->grid;
  if (values.size() != channels * grid.rays) {
    throw Error(ErrorKind::kInternal, "to_slots: one value per channel and ray is needed");
  }
  const std::size_t slots = grid.frame.slots;
  std::vector<float> out(channels * slots, 0.0F);
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const std::int32_t ray = grid.ray_of_slot[slot];
    if (ray < 0) continue;
    for (std::size_t c = 0; c < channels; ++c) {
      out[c * slots + slot] = values[c * grid.rays + static_cast<std::size_t>(ray)];
    }
  }
  return out;
}

namespace {

RenderOptions resolve(const Device& device, RenderOptions options) {
  validate(options);
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

/// SIM_MONTE_CARLO standard normal triples, the same always (splitmix64 and Box-Muller), in pairs of opposite
/// sign so that their mean is exactly 0.
void append_normal_samples(std::vector<double>& values) {
  std::uint64_t state = 0;
  const auto uniform = [&state] {
    state += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    z ^= z >> 31U;
    return (static_cast<double>(z >> 11U) + 0.5) * 0x1p-53;
  };
  for (int pair = 0; pair < SIM_MONTE_CARLO / 2; ++pair) {
    double sample[3];
    for (double& value : sample) {
      const double radius = std::sqrt(-2.0 * std::log(uniform()));
      value = radius * std::cos(2.0 * std::numbers::pi * uniform());
    }
    for (const double sign : {1.0, -1.0}) {
      for (const double value : sample) values.push_back(sign * value);
    }
  }
}

}  // namespace

Renderer::Renderer(const Device& device, const RenderOptions& options)
    : device_(device),
      options_(resolve(device, options)),
      all_(std::make_unique<AllStages>(device, options.precision)),
      buffers_(device, options.precision),
      gradients_(device, options.precision),
      actors_(device, options.precision),
      pictures_(device, options.precision) {}

Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Renderer::Stages& Renderer::stages_of(const Variant& variant) {
  auto& entry = all_->of_variant[variant];
  if (!entry) entry = std::make_unique<Stages>(device_, variant);
  return *entry;
}

void Renderer::render(const ParticleBuffers& particles,
                      const SensorRays& rays,
                      const View& view,
                      const EnvironmentBuffers* environment) {
  const RayGrid& grid = rays.grid();
  bool moving = false;
  const std::array<float, 3> behind = environment == nullptr ? view.background : std::array<float, 3>{};
  const bool still = options_.shutter_iterations == 0;
  const Pose middle = interpolate(view.scene_from_sensor_start, view.scene_from_sensor_end, 0.5);
  const auto constants = frame_constants(grid,
                                         still ? middle : view.scene_from_sensor_start,
                                         still ? middle : view.scene_from_sensor_end,
                                         options_,
                                         behind,
                                         moving);
  actor_motion_ = false;
  if (particles.actors > 0) {
    if (particles.actors > view.actors.size()) {
      throw Error(ErrorKind::kInternal, "render: the view has fewer actors than the particles");
    }
    const Eigen::Vector3d centre_ref(constants.data() + SIM_S_CENTRE_REF);
    std::vector<ActorView> actors = view.actors;
    for (ActorView& actor : actors) {
      if (!still) break;
      actor.scene_from_actor_start =
          interpolate(actor.scene_from_actor_start, actor.scene_from_actor_end, 0.5);
      actor.scene_from_actor_end = actor.scene_from_actor_start;
    }
    buffers_.constants.actors.assign(actor_constants(actors, centre_ref, actor_motion_));
  }
  moving = moving || actor_motion_;
  Variant variant;
  variant.actors = particles.actors > 0;
  variant.actor_motion = actor_motion_;
  variant.sensor = grid.type;
  variant.lens = grid.lens;
  variant.moving = moving;
  variant.origins = moving || grid.lever_arms;
  variant.sh_degree = options_.sh_degree == ShDegree::kAuto
                          ? particles.sh_degree
                          : std::min(particles.sh_degree, static_cast<int>(options_.sh_degree));
  variant.sh_storage = particles.sh_storage;
  variant.median = median_ = grid.type == SensorType::kLidar ? options_.median_distance : camera_median_;
  variant.precision = options_.precision;
  variant.projection = options_.projection;
  variant.extent = options_.extent;
  variant.order = options_.order;
  // Without bands above 0 a particle looks alike from everywhere.
  variant.sh_direction = variant.sh_degree > 0 ? options_.sh_direction : ShDirection::kParticle;
  // Double has the built-in functions anyway.
  variant.math = options_.precision == Precision::kFloat ? options_.math : Math::kFast;
  variant.shutter_iterations = std::max(options_.shutter_iterations, 1);
  variant.compensation =
      grid.type == SensorType::kCamera ? options_.camera_compensation : options_.lidar_compensation;
  variant.culling = rays.marked() && (options_.culling == Culling::kAlways ||
                                      (options_.culling == Culling::kAuto && rays.can_cull()));
  variant.shape = options_.shape.for_tile(static_cast<int>(grid.frame.tile_rays));
  current_ = &stages_of(variant);
  rays_ = rays;
  background_ = view.background;
  frame_ = grid.frame;
  frame_.particles = particles.count;
  frame_.stride = particles.stride;

  std::vector<double> sensor(constants.begin(), constants.end());
  if (options_.projection == Projection::kMonteCarlo) append_normal_samples(sensor);
  buffers_.constants.sensor.assign(sensor);
  FrameBuffers& b = buffers_;
  current_->rays.run(frame_, rays.buffers(), b.constants, b.rays);
  current_->project.run(frame_, particles, rays.buffers(), b.constants, b.projected);
  all_->bin.run(frame_, rays.buffers(), b.projected, options_.max_instances, b.binned);
  current_->render.run(
      frame_, particles, rays.buffers(), b.constants, b.rays, b.projected, b.binned, b.blended);
  graded_ = false;
  if (environment == nullptr) return;
  if (!all_->environment) {
    all_->environment.emplace(device_, options_.precision, options_.shape.lanes);
  }
  all_->environment->run(frame_, *environment, b.constants, b.rays, b.blended);
}

void Renderer::need_picture() const {
  if (!rays_ || rays_->grid().type != SensorType::kCamera) {
    throw Error(ErrorKind::kInternal, "grade: no picture has been rendered");
  }
}

void Renderer::grade(const ColorGridBuffers& grids, std::size_t index) {
  need_picture();
  const auto& c = rays_->grid().constants;
  all_->of(device_, grids)
      .forward.run(frame_,
                   static_cast<int>(c[SIM_S_WIDTH]),
                   static_cast<int>(c[SIM_S_HEIGHT]),
                   grids,
                   index,
                   buffers_.blended,
                   pictures_.picture);
  graded_ = true;
}

void Renderer::grade_backward(const ColorGridBuffers& grids,
                              std::size_t index,
                              const ColorGridScale& scale,
                              RealBuffer& grid_grads) {
  need_picture();
  const auto& c = rays_->grid().constants;
  auto& stage = all_->of(device_, grids).back;
  if (!stage) stage.emplace(device_, grids);
  stage->run(frame_,
             static_cast<int>(c[SIM_S_WIDTH]),
             static_cast<int>(c[SIM_S_HEIGHT]),
             grids,
             index,
             scale,
             buffers_.blended,
             gradients_,
             grid_grads);
}

void Renderer::environment_backward(const EnvironmentBuffers& environment,
                                    double tv_scale,
                                    RealBuffer& texture_grads) {
  if (!all_->environment) throw Error(ErrorKind::kInternal, "environment_backward: none has been rendered");
  auto& stage = all_->environment_back;
  if (!stage) stage.emplace(device_, options_.precision, options_.shape.lanes);
  stage->run(frame_,
             environment,
             tv_scale,
             buffers_.constants,
             buffers_.rays,
             buffers_.blended,
             gradients_,
             texture_grads);
}

ImageLoss Renderer::image_loss(const RealBuffer& truth, const ImageLossScale& scale) {
  return all_->image_loss.run(frame_, buffers_.rays, picture(), truth, scale, gradients_);
}

LidarLoss Renderer::lidar_loss(const RealBuffer& truth, const LidarLossScale& scale) {
  return all_->lidar_loss.run(frame_, buffers_.rays, buffers_.blended, truth, scale, gradients_);
}

RayResults Renderer::results() const {
  if (!rays_) throw Error(ErrorKind::kInternal, "results: nothing has been rendered");
  return results_of(rays_->grid(),
                    buffers_.blended.out.download_float(),
                    graded_ ? pictures_.picture.download_float() : std::vector<float>{},
                    background_,
                    median_);
}

void Renderer::exchange_outputs(RealBuffer& outputs, RealBuffer& picture) {
  buffers_.blended.out.exchange(outputs);
  if (graded_) pictures_.picture.exchange(picture);
  rays_.reset();
}

void Renderer::set_output_gradients(const std::vector<double>& gradients) {
  if (gradients.size() != std::size_t{5} * frame_.slots) {
    throw Error(ErrorKind::kInternal, "set_output_gradients: 5 values per slot are needed");
  }
  gradients_.grad_out.assign(gradients);
}

void Renderer::backward(const ParticleBuffers& particles,
                        RealBuffer& param_grads,
                        const BackwardExtras& extras) {
  if (current_ == nullptr || particles.count != frame_.particles) {
    throw Error(ErrorKind::kInternal, "backward: other particles than those last rendered");
  }
  if (!has_gradients(options_) || current_->own.sh_degree != particles.sh_degree ||
      particles.sh_storage != ShStorage::kFull) {
    throw Error(ErrorKind::kInternal,
                "backward: order per_ray, sh_direction ray, left out bands and halves have no gradients");
  }
  param_grads.reserve(particles.params.count());
  if (!current_->render_back) current_->render_back.emplace(device_, current_->own);
  if (!current_->project_back) current_->project_back.emplace(device_, current_->own);
  current_->render_back->run(frame_, rays_->buffers(), buffers_, extras, gradients_);
  current_->project_back->run(frame_, particles, buffers_, gradients_, param_grads);
}

PoseGradient Renderer::pose_gradient(const RealBuffer& param_grads) {
  if (!current_->pose) current_->pose.emplace(device_, current_->own);
  return current_->pose->run(
      frame_, rays_->buffers(), buffers_.constants, buffers_.projected, gradients_, param_grads);
}

}  // namespace simuli
