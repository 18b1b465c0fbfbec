#pragma once
#include <cstdint>

namespace simuli {

/// Votes of rays on whether a voxel absorbs them.
struct DarkVotes {
  static constexpr double kLeastShare = 0.75;
  static constexpr std::uint32_t kFewest = 4;

  std::uint32_t dropped = 0;  // rays that reached it and did not return
  std::uint32_t through = 0;  // rays that returned from behind it
  /// At least kLeastShare of the rays that reached it, and at least kFewest, did not return.
  [[nodiscard]] bool is_dark() const {
    return dropped >= kFewest &&
           static_cast<double>(dropped) >= kLeastShare * static_cast<double>(dropped + through);
  }
};

}  // namespace simuli
