#pragma once
// The rays of sensors that were used last on a device, for all scenes there.
#include <cstddef>
#include <functional>
#include <memory>
#include <unordered_set>
#include <vector>

#include "host/core/base/lru_cache.hpp"
#include "host/core/sensors/sensor.hpp"
#include "host/device/render/scene/sensor_rays.hpp"

namespace simuli {

/// What the rays of a sensor on the device depend on.
struct RaysKey {
  Sensor sensor;
  Precision precision;
  RayOptions options;
  std::vector<bool> requested;  // [rays]; empty: all
  bool operator==(const RaysKey& other) const {
    return sensor.has_rays_of(other.sensor) && precision == other.precision && options == other.options &&
           requested == other.requested;
  }
};
struct RaysHash {
  std::size_t operator()(const RaysKey& key) const {
    return key.sensor.rays_hash() ^ std::hash<std::vector<bool>>()(key.requested);
  }
};

/// A budget of bytes, device and host together. Rays that come back are kept within it; those that were used
/// once, which a rig varied at random never asks for again, within a small part of it. A sensor that went
/// before it came back is known by its hash, and kept the next time.
class RayCache {
 public:
  explicit RayCache(std::size_t budget_bytes);

  /// The one of `device`, for as long as anybody has it: a quarter of the device's memory.
  [[nodiscard]] static std::shared_ptr<RayCache> of(const Device& device);

  [[nodiscard]] SensorRays get(const RaysKey& key, const std::function<SensorRays()>& make);
  [[nodiscard]] std::size_t size() const { return once_.size() + again_.size(); }
  [[nodiscard]] std::size_t used_bytes() const { return once_.used_bytes() + again_.used_bytes(); }

 private:
  using Cache = LruCache<SensorRays, RaysKey, RaysHash>;
  static constexpr std::size_t kMostKnown = 65536;
  Cache once_, again_;
  std::unordered_set<std::size_t> known_;  // hashes of what was used
};

}  // namespace simuli
