#pragma once
// Cache of sensors' rays on a device, shared by all scenes.
#include <cstddef>
#include <functional>
#include <memory>
#include <unordered_set>
#include <vector>

#include "host/core/base/lru_cache.hpp"
#include "host/core/sensors/sensor.hpp"
#include "host/device/render/scene/sensor_rays.hpp"

namespace simuli {

/// Key of a sensor's rays on the device.
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

/// A cache with a budget in bytes, device and host together. Rays used repeatedly share the budget; rays used
/// once, as in randomly varied rigs, get only a small part of it. Hashes of evicted sensors are remembered, so
/// that they count as repeated at their next use.
class RayCache {
 public:
  explicit RayCache(std::size_t budget_bytes);

  /// Returns the cache of `device`, which lives as long as a user: a quarter of the device's memory.
  [[nodiscard]] static std::shared_ptr<RayCache> of(const Device& device);

  [[nodiscard]] SensorRays get(const RaysKey& key, const std::function<SensorRays()>& make);
  [[nodiscard]] std::size_t size() const { return once_.size() + again_.size(); }
  [[nodiscard]] std::size_t used_bytes() const { return once_.used_bytes() + again_.used_bytes(); }

 private:
  using Cache = LruCache<SensorRays, RaysKey, RaysHash>;
  static constexpr std::size_t kMostKnown = 65536;
  Cache once_, again_;
  std::unordered_set<std::size_t> known_;  // hashes of used keys
};

}  // namespace simuli
