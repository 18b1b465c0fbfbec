#pragma once
// A sensor's rays on a device, and numbers that belong to them.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/render/options/options.hpp"
#include "host/render/rays/ray_buffers.hpp"
#include "host/render/rays/ray_grid.hpp"

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

/// A sensor ready to render: its ray grid, on host and device. A handle: copies refer to the same rays, and
/// what a Pass needs of them it keeps alive, so that a temporary may be rendered.
class SensorRays {
 public:
  SensorRays(const Device& device, const Camera& camera, const RenderOptions& options);
  /// Rays in the LiDAR's blind arcs are never rendered.
  SensorRays(const Device& device,
             const LidarModel& lidar,
             const LidarRays& rays,
             const RenderOptions& options);

  /// From now on only the rays with requested[ray] are rendered; the others are slots without a ray, and
  /// their results the background. requested[rays]; empty: all. A LiDAR's ray mask is rebuilt. Waits, unless
  /// that is so already. Error{kUsage} for another number of flags.
  void request(const std::vector<bool>& requested);

  [[nodiscard]] const RayGrid& grid() const { return state_->grid; }
  /// Whether there is a ray mask, and whether it has a cell without a ray.
  [[nodiscard]] bool marked() const { return state_->marks; }
  [[nodiscard]] bool can_cull() const { return state_->can_cull; }
  [[nodiscard]] const RayBuffers& buffers() const { return state_->buffers; }
  /// The map between slots and rays on the device, made when first asked for.
  [[nodiscard]] const RayMap& map() const;
  /// Device memory, and as much on the host.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] Precision precision() const { return state_->precision; }
  /// Whether both are handles of the same rays.
  [[nodiscard]] bool operator==(const SensorRays& other) const { return state_ == other.state_; }

  /// values[channels][rays] in ray order -> [channels][slots] in slot order; slots without a ray get 0.
  template <class T>
  [[nodiscard]] std::vector<T> to_slots(const std::vector<T>& values, std::size_t channels) const;
  /// Error{kUsage} naming the option when rays made with others would be rendered with `options`.
  void need_made_with(const RenderOptions& options) const;

 private:
  struct State {
    State(const Device& device, RayGrid rays, const RenderOptions& options);
    void mark_rays(RayMaskSize size);
    void place_requested();
    Device device;
    Precision precision;
    double camera_filter_px2;
    double camera_near_m;
    Culling culling;
    bool marks;  // a LiDAR's that culls
    RayMaskSize mask_size;
    std::vector<bool> blind;      // [rays] of a LiDAR with blind arcs, else empty
    std::vector<bool> requested;  // [rays]; empty: all that there are
    std::optional<RayMap> map;
    RayGrid grid;
    RayBuffers buffers;
    bool can_cull = false;
  };
  friend class RayValues;
  SensorRays(const Device& device, RayGrid grid, const RenderOptions& options);
  std::shared_ptr<State> state_;
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
