#pragma once
// Estimates the device memory of a training before it starts.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "host/device/runtime/device.hpp"
#include "io/log/log.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

struct MemoryItem {
  std::string name;
  std::uint64_t bytes = 0;
};

/// Memory by purpose, largest first. An upper estimate: sets at the size that densification may reach, and as
/// many tile pairs as particles of the larger set, an upper bound for street scenes.
struct MemoryNeed {
  std::vector<MemoryItem> items;
  std::map<std::string, std::uint64_t> by_buffer;  // bytes by buffer name
  std::uint64_t total = 0;
  std::uint64_t largest_buffer = 0;

  /// Returns "3.2 GB: camera set 1.1 GB, ...".
  [[nodiscard]] std::string text() const;
};
/// Sums the buffer tables (host/device/render/device/buffer_table.hpp) of a training on `device`.
[[nodiscard]] MemoryNeed training_memory(const Device& device,
                                         const Log& log,
                                         const Scene& scene,
                                         const TrainingOptions& options);

/// Returns the host memory in bytes for decoded frames (host_cache_bytes): at most a quarter of the host's
/// memory and an eighth of its memory limit.
[[nodiscard]] std::size_t frame_budget(const TrainingOptions& options);
/// Returns the bytes of all decoded frames of a log.
[[nodiscard]] std::uint64_t frame_bytes(const Log& log, const FrameSelection& frames);

/// Throws Error{kDevice} with the sizes when the estimate exceeds train.memory_bytes or the device's memory, or
/// when one buffer exceeds the device's allocation limit.
void need_memory(const Device& device, const Log& log, const Scene& scene, const TrainingOptions& options);

}  // namespace simuli
