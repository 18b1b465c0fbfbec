#pragma once
// Into how many chunks a drive is cut so that its training fits in memory.
#include "host/device/runtime/device.hpp"
#include "io/log/log.hpp"
#include "optim/train/chunk/chunks.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

/// Whether a training is to fit in memory by cutting its drive as need be.
[[nodiscard]] bool plans_chunks(const TrainingOptions& options);

/// Error{kUsage} for what cannot be told of one chunk and be true of the next, where chunk.length_m cuts
/// the drive.
void need_uncut(const TrainingOptions& options);

/// As few chunks as keep the need of host_memory_bytes and memory_bytes (or of the device's own memory).
/// What a chunk needs is estimated: pieces of 20 and 60 m from the middle of the drive are initialised, and
/// their voxels and particles taken for linear in length; the device's need is training_memory()'s of so
/// many, the host's a measured number of bytes for each voxel, particle and ray of a sweep. It depends on
/// log, options and device alone. Error{kDevice}, Error{kUsage} for the host, when the shortest chunk (20
/// m), or the finished scene, does not fit; the same of the whole drive where options keep it in one piece.
[[nodiscard]] ChunkPlan plan_chunks(const Device& device,
                                         const Log& log,
                                         const TrainingOptions& options,
                                         const DrivenPath& path);

}  // namespace simuli
