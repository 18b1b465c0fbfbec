#pragma once
// The paper's anchoring loss in a training (METHOD section 10).
#include <cstdint>
#include <memory>
#include <vector>

#include "host/device/render/device/buffer_table.hpp"
#include "optim/train/set_hook.hpp"

namespace simuli {

/// Returns the hook that anchors the camera set to the LiDAR set; null if anchor.weight is 0 or a set is empty. All
/// arguments must outlive it.
[[nodiscard]] std::unique_ptr<SetHook> make_anchors(const Device& device,
                                                    const TrainOptions& options,
                                                    TrainedSet& camera,
                                                    TrainedSet& lidar);

/// Returns the buffers of make_anchors() for sets of these sizes.
[[nodiscard]] std::vector<BufferBytes> anchor_bytes(const Device& device,
                                                    const TrainOptions& options,
                                                    std::uint64_t camera_particles,
                                                    std::uint64_t lidar_particles);

}  // namespace simuli
