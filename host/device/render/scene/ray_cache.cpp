#include "host/device/render/scene/ray_cache.hpp"

#include <algorithm>
#include <map>
#include <mutex>

namespace simuli {
namespace {

constexpr std::size_t kMostOnce = std::size_t{256} << 20U;

std::size_t once_of(std::size_t budget) { return std::min(budget / 4, kMostOnce); }

}  // namespace

RayCache::RayCache(std::size_t budget_bytes)
    : once_(once_of(budget_bytes)), again_(budget_bytes - once_of(budget_bytes)) {}

std::shared_ptr<RayCache> RayCache::of(const Device& device) {
  // Keyed by the device's state, which owners of the cache keep alive.
  static std::mutex mutex;
  static std::map<const void*, std::weak_ptr<RayCache>> caches;
  const std::lock_guard lock(mutex);
  std::erase_if(caches, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<RayCache>& kept = caches[&device.state()];
  std::shared_ptr<RayCache> cache = kept.lock();
  if (!cache) {
    cache = std::make_shared<RayCache>(static_cast<std::size_t>(device.info().global_bytes / 4));
    kept = cache;
  }
  return cache;
}

SensorRays RayCache::get(const RaysKey& key, const std::function<SensorRays()>& make) {
  // The key contains the sensor's rays as well.
  const auto bytes_of = [&](const SensorRays& rays) {
    return rays.bytes() + key.requested.size() / 8 +
           (key.sensor.is_camera() ? 0 : key.sensor.ray_count() * 4 * sizeof(float));
  };
  if (const auto found = again_.find(key)) return *found;
  if (const auto found = once_.take(key)) {
    return *again_.get(
        key, [&] { return *found; }, bytes_of);
  }
  if (known_.size() >= kMostKnown) known_.clear();
  const bool comes_back = !known_.insert(RaysHash()(key)).second;
  return *(comes_back ? again_ : once_).get(key, make, bytes_of);
}

}  // namespace simuli
