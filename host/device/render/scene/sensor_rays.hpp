#pragma once
// A sensor's rays on a device, and numbers that belong to them.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/device/render/options/options.hpp"
#include "host/device/render/rays/ray_buffers.hpp"
#include "host/device/render/rays/ray_grid.hpp"

namespace simuli {

struct RayMapSizes {
  std::uint64_t slots = 0;
  std::uint64_t rays = 0;
};
/// The map between slots and rays on the device.
struct RayMap : BufferTable<RayMapSizes> {
  RayMap(const Device& device, const RayGrid& grid);
  /// [slots], -1: none.
  Array<std::int32_t> ray_of_slot{*this, "ray_of_slot", [](const RayMapSizes& s) { return s.slots; }};
  /// [rays], -1: none, of a pixel that the lens sees nothing through.
  Array<std::int32_t> slot_of_ray{*this, "slots_of_map", [](const RayMapSizes& s) { return s.rays; }};
};

/// A sensor ready to render: its ray grid, on host and device, and which of its rays are asked for. A value
/// that never changes; copies share what it is made of, and a Pass keeps it alive, so that a temporary may be
/// rendered.
class SensorRays {
 public:
  SensorRays(const Device& device, const Camera& camera, const RenderOptions& options);
  /// Rays in the LiDAR's blind arcs are never rendered.
  SensorRays(const Device& device,
             const LidarModel& lidar,
             const LidarRays& rays,
             const RenderOptions& options);

  /// The same sensor's, of which those with flags[ray] alone are rendered; the others are slots without a
  /// ray, and their results the background. flags[rays], whatever was asked for before. A LiDAR's ray mask is
  /// made anew; a camera's particles are left out outside the rectangle of its pixels that are asked for. Waits.
  /// Error{kUsage} for another number of flags.
  [[nodiscard]] SensorRays requested(std::vector<bool> flags) const;

  [[nodiscard]] const RayGrid& grid() const { return shared_->grid; }
  /// Whether a LiDAR's ray mask can leave particles out that no ray asked for reaches.
  [[nodiscard]] bool can_cull() const { return request_->can_cull; }
  /// The grid's, with where those that are asked for are.
  [[nodiscard]] const shared::ModelConstants<double>& model() const { return request_->model; }
  [[nodiscard]] RayBuffers buffers() const { return {shared_->layout, request_->rays}; }
  /// The map between slots and rays on the device, made when first asked for.
  [[nodiscard]] const RayMap& map() const;
  /// Of the device and of the host together; what all requests have in common counts for each.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] Precision precision() const { return shared_->precision; }
  /// Whether both are of the same sensor, made once.
  [[nodiscard]] bool is_of_sensor_of(const SensorRays& other) const { return shared_ == other.shared_; }

  /// values[channels][rays] in ray order -> [channels][slots] in slot order; slots without a ray get 0.
  template <class T>
  [[nodiscard]] std::vector<T> to_slots(const std::vector<T>& values, std::size_t channels) const;
  /// Error{kUsage} naming the option when rays made with others would be rendered with `options`.
  void need_made_with(const RenderOptions& options) const;

 private:
  /// What all requests have in common.
  struct Shared {
    Shared(const Device& device, RayGrid rays, std::vector<bool> seeing, const RenderOptions& options);
    Device device;
    Precision precision;
    RayOptions options;
    std::vector<bool> sees;  // [rays] false in a LiDAR's blind arcs; empty: all do
    RayGrid grid;
    RayLayout layout;
    mutable std::optional<RayMap> map;
  };
  struct Request {
    Request(const Shared& of, const std::vector<bool>& wanted);
    RequestedRays rays;
    shared::ModelConstants<double> model;
    bool can_cull = false;
  };
  friend class RayValues;
  SensorRays(const Device& device, RayGrid grid, std::vector<bool> sees, const RenderOptions& options);
  std::shared_ptr<const Shared> shared_;
  std::shared_ptr<const Request> request_;
};

/// What each ray of a sensor recorded, on the device beside them: what losses compare with.
class RayValues {
 public:
  /// values[channels][rays] in ray order; `name`: of the buffer. Error{kUsage} for another number of them.
  RayValues(const SensorRays& rays,
            const std::vector<float>& values,
            std::size_t channels,
            const std::string& name = "values of rays");
  /// That are made on the device; none yet.
  RayValues(const SensorRays& rays, std::size_t channels, const std::string& name);

  [[nodiscard]] const SensorRays& rays() const { return rays_; }
  [[nodiscard]] std::size_t channels() const { return channels_; }
  [[nodiscard]] const RealBuffer& slots() const { return slots_; }  // [channels][slots]; 0 without a ray
  [[nodiscard]] RealBuffer& slots() { return slots_; }

 private:
  SensorRays rays_;
  std::size_t channels_;
  RealBuffer slots_;
};

}  // namespace simuli
