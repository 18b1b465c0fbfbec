#pragma once
// What a training takes of the device's memory, told before it starts.
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

/// Items, the largest first. An upper estimate: sets at the size that densification may take them to, and as
/// many tile pairs as particles of the larger set, which is what street scenes stay below.
struct MemoryNeed {
  std::vector<MemoryItem> items;
  std::map<std::string, std::uint64_t> by_buffer;  // bytes by the buffers' names
  std::uint64_t total = 0;
  std::uint64_t largest_buffer = 0;

  /// "3.2 GB: camera set 1.1 GB, ...".
  [[nodiscard]] std::string text() const;
};
/// The tables of what a training keeps on `device` (host/device/render/device/buffer_table.hpp), added up.
[[nodiscard]] MemoryNeed training_memory(const Device& device,
                                         const Log& log,
                                         const Scene& scene,
                                         const TrainingOptions& options);

/// Of the host, for frames as their files decode (host_cache_bytes): a quarter of its memory at most, and an
/// eighth of what it is limited to.
[[nodiscard]] std::size_t frame_budget(const TrainingOptions& options);
/// What all frames of a log take there.
[[nodiscard]] std::uint64_t frame_bytes(const Log& log, const FrameSelection& frames);

/// Error{kDevice} with the numbers when that is more than train.memory_bytes, or than the device has, or
/// when one buffer would be larger than the device allows.
void need_memory(const Device& device, const Log& log, const Scene& scene, const TrainingOptions& options);

}  // namespace simuli
