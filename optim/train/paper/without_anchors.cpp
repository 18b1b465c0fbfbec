// Replaces anchors.cpp in builds without SIMULI_PAPER.
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "optim/train/paper/anchors.hpp"
#include "optim/train/train_options.hpp"

namespace simuli {

std::unique_ptr<SetHook> make_anchors(const Device& /*device*/,
                                      const TrainOptions& options,
                                      TrainedSet& /*camera*/,
                                      TrainedSet& /*lidar*/) {
  if (options.anchor.weight == 0.0) return nullptr;
  throw Error(ErrorKind::kUsage,
              fmt::format("anchor.weight: found {}, allowed 0 in builds without SIMULI_PAPER",
                          options.anchor.weight));
}

std::vector<BufferBytes> anchor_bytes(const Device& /*device*/,
                                      const TrainOptions& /*options*/,
                                      std::uint64_t /*camera_particles*/,
                                      std::uint64_t /*lidar_particles*/) {
  return {};
}

}  // namespace simuli
