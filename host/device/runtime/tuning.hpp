#pragma once
// How kernels are launched on a device, where a search has found what suits it
// (host/device/render/scene/tuning.hpp).
#include <cstddef>
#include <optional>

#include "host/device/runtime/device.hpp"

namespace simuli {

/// 0: as suits the kind of device.
struct DeviceTuning {
  int lanes = 0, vectors = 0, work_items = 0;  // of a tile's 256 rays in float (LaneShape)
  int group = 0;                               // work-items of a group of Kernel::run_over()
  bool operator==(const DeviceTuning&) const = default;
};

/// What a device is used with: what is stored for it (save_tuning()) when it was opened, else nothing but 0.
[[nodiscard]] const DeviceTuning& tuning_of(const Device& device);
/// For renderers and kernels made from now on.
void set_tuning(const Device& device, const DeviceTuning& tuning);

/// What is stored in cache_folder() for a device of that name with that driver; nothing when there is none,
/// or nothing sound.
[[nodiscard]] std::optional<DeviceTuning> stored_tuning(const DeviceInfo& device);
/// Stores it, or with 0 throughout takes it away. Error{kInput} when the cache can't be written, or there is
/// none.
void save_tuning(const DeviceInfo& device, const DeviceTuning& tuning);

}  // namespace simuli
