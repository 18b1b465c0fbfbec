#pragma once
// Plans the number of chunks so that a training fits in memory.
#include "host/device/runtime/device.hpp"
#include "io/log/log.hpp"
#include "optim/train/chunk/chunks.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

/// Whether a training may be cut into chunks to fit in memory.
[[nodiscard]] bool plans_chunks(const TrainingOptions& options);

/// Throws Error{kUsage} for options that cannot differ between chunks, where chunk.length_m cuts the drive.
void need_uncut(const TrainingOptions& options);

/// Returns the smallest number of chunks that keeps within host_memory_bytes and memory_bytes (or the device's
/// own memory). The memory of a chunk is estimated: pieces of 20 and 60 m from the middle of the drive are
/// initialised, and their voxels and particles extrapolated linearly in length; device memory follows from
/// training_memory(), host memory from measured bytes per voxel, particle and sweep ray. The result depends
/// only on log, options and device. Throws Error{kDevice} (device) or Error{kUsage} (host) when the shortest
/// chunk (20 m) or the finished scene does not fit, or the whole drive where options require one run.
[[nodiscard]] ChunkPlan plan_chunks(const Device& device,
                                         const Log& log,
                                         const TrainingOptions& options,
                                         const DrivenPath& path);

}  // namespace simuli
