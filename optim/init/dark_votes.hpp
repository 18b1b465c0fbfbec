#pragma once
#include <cstdint>

namespace simuli {

/// What rays say of a voxel: whether what is there sends nothing back.
struct DarkVotes {
  static constexpr double kLeastShare = 0.75;
  static constexpr std::uint32_t kFewest = 4;

  std::uint32_t dropped = 0;  // rays that reached it and didn't return
  std::uint32_t through = 0;  // that returned from behind
  /// At least kLeastShare of the rays that reached it did not return, and kFewest of them.
  [[nodiscard]] bool is_dark() const {
    return dropped >= kFewest &&
           static_cast<double>(dropped) >= kLeastShare * static_cast<double>(dropped + through);
  }
};

}  // namespace simuli
