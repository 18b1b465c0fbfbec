#include "host/device/render/scene/sensor_rays.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>
#include <variant>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/device/render/frame/room.hpp"
#include "host/device/render/rays/ray_mask.hpp"

namespace simuli {
namespace {

RayOptions resolved(RayOptions options) {
  options.camera_filter_px2 = camera_filter_px2(options);
  return options;
}

/// `wanted`: [rays], or empty for all.
RequestedRays masked_rays(const Device& device,
                          const RayGrid& grid,
                          Precision precision,
                          const std::vector<bool>& wanted) {
  RequestedRays out(device, precision);
  if (wanted.empty()) {
    out.sensor_ray.assign(grid.sensor_ray);
    return out;
  }
  std::vector<float> sensor_ray = grid.sensor_ray;
  const std::size_t slots = grid.frame.slots;
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const std::int32_t ray = grid.ray_of_slot[slot];
    if (ray < 0 || wanted[static_cast<std::size_t>(ray)]) continue;
    for (std::size_t k = 0; k < 3; ++k) sensor_ray[k * slots + slot] = 0.0F;
  }
  out.sensor_ray.assign(sensor_ray);
  return out;
}

/// Finds the bounding rectangle of a camera's `wanted` pixels [rays].
void print_rectangle(const RayGrid& grid,
                    const std::vector<bool>& wanted,
                    shared::ModelConstants<double>& model) {
  Eigen::AlignedBox2d box;
  const auto width = static_cast<std::size_t>(grid.width);
  for (std::size_t ray = 0; ray < wanted.size(); ++ray) {
    if (wanted[ray]) box.extend(Eigen::Vector2d(ray % width, ray / width));
  }
  if (box.isEmpty())
    box = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(-1.0)};  // an empty rectangle
  model.first_column = box.min().x();
  model.last_column = box.max().x();
  model.first_row = box.min().y();
  model.last_row = box.max().y();
}

/// Rays outside the LiDAR's blind arcs, [rays]; empty: all.
std::vector<bool> not_blind(const LidarModel& model, const LidarRays& rays) {
  const auto* const lidar = std::get_if<Lidar>(&model);
  if (lidar == nullptr || !lidar->has_blind()) return {};
  std::vector<bool> sees(rays.azimuth.size());
  for (std::size_t i = 0; i < sees.size(); ++i) sees[i] = !is_blind(model, rays, i);
  return sees;
}

}  // namespace

SensorRays::Shared::Shared(const Device& on,
                           RayGrid rays,
                           std::vector<bool> seeing,
                           const RenderOptions& with)
    : device(on),
      precision(with.precision),
      options(resolved(with)),
      sees(std::move(seeing)),
      grid(std::move(rays)),
      layout(on, grid, with.precision) {}

SensorRays::Request::Request(const Shared& of, const std::vector<bool>& wanted)
    : rays(masked_rays(of.device, of.grid, of.precision, wanted)), model(of.grid.model) {
  if (of.options.culling == Culling::kOff) return;
  if (of.grid.type == SensorType::kCamera) {
    if (!wanted.empty()) print_rectangle(of.grid, wanted, model);
    return;
  }
  const bool all = std::find(wanted.begin(), wanted.end(), false) == wanted.end();
  can_cull = RayMaskStage(of.device, of.precision).run(of.grid, all, of.layout, rays, model);
}

SensorRays::SensorRays(const Device& device,
                       RayGrid grid,
                       std::vector<bool> sees,
                       const RenderOptions& options)
    : shared_(std::make_shared<const Shared>(device, std::move(grid), std::move(sees), options)),
      request_(std::make_shared<const Request>(*shared_, shared_->sees)) {}
SensorRays::SensorRays(const Device& device, const Camera& camera, const RenderOptions& options)
    : SensorRays(
          device, make_ray_grid(with_room_on(device, camera, options.precision), options), {}, options) {}
SensorRays::SensorRays(const Device& device,
                       const LidarModel& model,
                       const LidarRays& rays,
                       const RenderOptions& options)
    : SensorRays(device, make_ray_grid(device, model, rays), not_blind(model, rays), options) {}

SensorRays SensorRays::requested(std::vector<bool> flags) const {
  const std::size_t rays = shared_->grid.rays;
  if (flags.size() != rays) {
    throw Error(ErrorKind::kUsage,
                fmt::format("request: found {} flags, allowed one for each of {} rays", flags.size(), rays));
  }
  for (std::size_t ray = 0; ray < shared_->sees.size(); ++ray) flags[ray] = flags[ray] && shared_->sees[ray];
  SensorRays out = *this;
  out.request_ = std::make_shared<const Request>(*shared_, flags);
  return out;
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
  if (!shared_->map) shared_->map.emplace(shared_->device, shared_->grid);
  return *shared_->map;
}

std::size_t SensorRays::bytes() const {
  const RayLayout& l = shared_->layout;
  const RequestedRays& r = request_->rays;
  const RayGrid& g = shared_->grid;
  const std::size_t real = shared_->precision == Precision::kFloat ? sizeof(float) : sizeof(double);
  const std::size_t on_device =
      real * (r.sensor_ray.capacity() + l.u.capacity() + l.row_elevation.capacity()) + l.row_lut.bytes() +
      l.tile_rows.bytes() + l.tile_row_of_row.bytes() + l.column_of_bin.bytes() + r.mask_row_of_row.bytes() +
      r.areas.bytes();
  const std::size_t of_map = (g.ray_of_slot.size() + g.rays) * sizeof(std::int32_t);  // copied when a frame is read
  const std::size_t on_host =
      (g.sensor_ray.size() + g.u.size()) * sizeof(float) + g.row_elevation.size() * sizeof(double) +
      (g.ray_of_slot.size() + g.row_lut.size()) * sizeof(std::int32_t) +
      (g.tile_rows.size() + g.tile_row_of_row.size() + g.column_of_bin.size()) * sizeof(std::uint32_t) +
      shared_->sees.size() / 8;
  return on_device + of_map + on_host;
}

template <class T>
std::vector<T> SensorRays::to_slots(const std::vector<T>& values, std::size_t channels) const {
  const RayGrid& grid = shared_->grid;
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
  RenderOptions own = options, wanted = options;
  own.precision = shared_->precision;
  static_cast<RayOptions&>(own) = shared_->options;
  static_cast<RayOptions&>(wanted) = resolved(options);
  if (own == wanted) return;
  const Fields found = fields_of(own), allowed = fields_of(wanted);
  for (std::size_t i = 0; i < found.all().size(); ++i) {
    const std::string text = found.all()[i].text(), other = allowed.all()[i].text();
    if (text == other) continue;
    throw Error(
        ErrorKind::kUsage,
        fmt::format("rays: {}: found {}, allowed {} as the renderer's", found.all()[i].key, text, other));
  }
}

RayValues::RayValues(const SensorRays& rays,
                     const std::vector<float>& values,
                     std::size_t channels,
                     const std::string& name)
    : rays_(rays), channels_(channels), slots_(rays.shared_->device, name, rays.precision()) {
  slots_.assign(rays.to_slots(values, channels));
}

RayValues::RayValues(const SensorRays& rays, std::size_t channels, const std::string& name)
    : rays_(rays),
      channels_(channels),
      slots_(rays.shared_->device, name, rays.precision(), channels * rays.grid().frame.slots) {}

}  // namespace simuli
