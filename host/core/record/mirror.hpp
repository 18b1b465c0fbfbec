#pragma once
// Completes actors that were recorded from one side only, by mirroring.
#include <string>

#include "host/core/record/support_record.hpp"
#include "host/core/scene/scene.hpp"

namespace simuli {

/// Number of recorded frames of cameras and LiDARs that view an actor from its left and from its right, at
/// least kSidewards to the side; ignores occlusion.
struct SidesSeen {
  std::size_t left = 0, right = 0;
};
inline constexpr double kSidewards = 0.1;
/// Throws Error{kUsage} for a name that the record does not contain.
[[nodiscard]] SidesSeen sides_seen(const SupportRecord& record, const std::string& actor);

/// Replaces the particles of the actor's unseen side by those of the seen side, mirrored at its middle,
/// including colours: vehicles are symmetric except for lettering. Returns false and does nothing when each
/// side was seen in more than a tenth of the frames that show either. `recorded`: its name in the record.
/// Throws Error{kUsage} for unknown names.
bool mirror_actor(Scene& scene,
                  const SupportRecord& record,
                  const std::string& actor,
                  const std::string& recorded);

}  // namespace simuli
