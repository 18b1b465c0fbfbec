#include "host/render/scene/sensor_rays.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>
#include <variant>

#include "host/base/error.hpp"
#include "host/render/frame/room.hpp"
#include "host/render/rays/ray_mask.hpp"

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
      camera_filter_px2(simuli::camera_filter_px2(options)),
      camera_near_m(options.camera_near_m),
      culling(options.culling),
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
    throw Error(
        ErrorKind::kUsage,
        fmt::format(
            "request: found {} flags, allowed one for each of {} rays", requested.size(), s.grid.rays));
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

template <class T>
std::vector<T> SensorRays::to_slots(const std::vector<T>& values, std::size_t channels) const {
  const RayGrid& grid = state_->grid;
  if (values.size() != channels * grid.rays) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format(
            "values of rays: found {}, allowed {} for each of {} rays", values.size(), channels, grid.rays));
  }
  const std::size_t slots = grid.frame.slots;
  std::vector<T> out(channels * slots, T{0});
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const std::int32_t ray = grid.ray_of_slot[slot];
    if (ray < 0) continue;
    for (std::size_t c = 0; c < channels; ++c) {
      out[c * slots + slot] = values[c * grid.rays + static_cast<std::size_t>(ray)];
    }
  }
  return out;
}
template std::vector<float> SensorRays::to_slots(const std::vector<float>& values,
                                                 std::size_t channels) const;
template std::vector<double> SensorRays::to_slots(const std::vector<double>& values,
                                                  std::size_t channels) const;

void SensorRays::need_made_with(const RenderOptions& options) const {
  const State& s = *state_;
  const auto need = [](bool holds, const char* option, const auto& found, const auto& allowed) {
    if (holds) return;
    throw Error(ErrorKind::kUsage,
                fmt::format("rays: {}: found {}, allowed {} as the renderer's", option, found, allowed));
  };
  const auto bits = [](Precision p) { return p == Precision::kDouble ? "double" : "float"; };
  need(s.precision == options.precision, "precision", bits(s.precision), bits(options.precision));
  if (s.grid.type == SensorType::kCamera) {
    const double filter_px2 = camera_filter_px2(options);
    need(s.camera_filter_px2 == filter_px2, "camera_filter_px2", s.camera_filter_px2, filter_px2);
    need(s.camera_near_m == options.camera_near_m, "camera_near_m", s.camera_near_m, options.camera_near_m);
    return;
  }
  const auto culls = [](Culling culling) { return culling == Culling::kOff ? "off" : "on"; };
  need((s.culling == Culling::kOff) == (options.culling == Culling::kOff),
       "culling",
       culls(s.culling),
       culls(options.culling));
}

RayValues::RayValues(const SensorRays& rays,
                     const std::vector<float>& values,
                     std::size_t channels,
                     const std::string& name)
    : rays_(rays), channels_(channels), slots_(rays.state_->device, name, rays.precision()) {
  slots_.assign(rays.to_slots(values, channels));
}

RayValues::RayValues(const SensorRays& rays, std::size_t channels, const std::string& name)
    : rays_(rays),
      channels_(channels),
      slots_(rays.state_->device, name, rays.precision(), channels * rays.grid().frame.slots) {}

}  // namespace simuli
