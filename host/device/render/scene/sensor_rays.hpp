#pragma once
// A sensor's rays on a device, and values attached to them.
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
  /// [rays], -1: a pixel without a ray through the lens.
  Array<std::int32_t> slot_of_ray{*this, "slots_of_map", [](const RayMapSizes& s) { return s.rays; }};
};

/// A sensor ready to render: its ray grid on host and device, and its requested rays. An immutable value;
/// copies share their data, and a Pass keeps it alive, so that temporaries may be rendered.
class SensorRays {
 public:
  SensorRays(const Device& device, const Camera& camera, const RenderOptions& options);
  /// Rays in the LiDAR's blind arcs are never rendered.
  SensorRays(const Device& device,
             const LidarModel& lidar,
             const LidarRays& rays,
             const RenderOptions& options);

  /// Returns the same sensor with only the rays flags[ray]; other slots have no ray and show the background.
  /// flags[rays], independent of earlier requests. Rebuilds a LiDAR's ray mask; limits a camera to the bounding
  /// rectangle of the requested pixels. Waits. Throws Error{kUsage} for another number of flags.
  [[nodiscard]] SensorRays requested(std::vector<bool> flags) const;

  [[nodiscard]] const RayGrid& grid() const { return shared_->grid; }
  /// Whether a LiDAR's ray mask can cull particles that no requested ray hits.
  [[nodiscard]] bool can_cull() const { return request_->can_cull; }
  /// The grid's constants, with the bounds of the requested rays.
  [[nodiscard]] const shared::ModelConstants<double>& model() const { return request_->model; }
  [[nodiscard]] RayBuffers buffers() const { return {shared_->layout, request_->rays}; }
  /// The map between slots and rays on the device, made on demand.
  [[nodiscard]] const RayMap& map() const;
  /// Bytes on device and host; data common to several requests count for each.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] Precision precision() const { return shared_->precision; }
  /// Whether both share the rays of one sensor object.
  [[nodiscard]] bool is_of_sensor_of(const SensorRays& other) const { return shared_ == other.shared_; }

  /// Reorders values[channels][rays] from ray order to [channels][slots]; slots without a ray get 0.
  template <class T>
  [[nodiscard]] std::vector<T> to_slots(const std::vector<T>& values, std::size_t channels) const;
  /// Throws Error{kUsage} with the option when the rays were made with other options than `options`.
  void need_made_with(const RenderOptions& options) const;

 private:
  /// Data common to all requests.
  struct Shared {
    Shared(const Device& device, RayGrid rays, std::vector<bool> seeing, const RenderOptions& options);
    Device device;
    Precision precision;
    RayOptions options;
    std::vector<bool> sees;  // [rays] false in a LiDAR's blind arcs; empty: no blind arcs
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

/// Recorded values by ray on the device: the ground truth of losses.
class RayValues {
 public:
  /// values[channels][rays] in ray order; `name` of the buffer. Throws Error{kUsage} for another number of
  /// values.
  RayValues(const SensorRays& rays,
            const std::vector<float>& values,
            std::size_t channels,
            const std::string& name = "values of rays");
  /// Allocates values that the device computes.
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
