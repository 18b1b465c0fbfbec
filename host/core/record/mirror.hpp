#pragma once
// Actors of which one side alone was ever seen.
#include <string>

#include "host/core/record/support_record.hpp"
#include "host/core/scene/scene.hpp"

namespace simuli {

/// From how many recorded frames of cameras and LiDARs an actor was looked at from its left and from its
/// right, at least kSidewards of the way across; whatever stood between.
struct SidesSeen {
  std::size_t left = 0, right = 0;
};
inline constexpr double kSidewards = 0.1;
/// Error{kUsage} for a name that the record has not.
[[nodiscard]] SidesSeen sides_seen(const SupportRecord& record, const std::string& actor);

/// Gives the actor's other side the particles of the one that was seen, mirrored at its middle, colours and
/// all, in place of its own: vehicles are alike on both sides, but for what is written on them. Does nothing,
/// and returns false, where both sides were seen from more than a tenth of the frames that saw either.
/// `recorded`: its name in the record. Error{kUsage} for names that there are not.
bool mirror_actor(Scene& scene,
                  const SupportRecord& record,
                  const std::string& actor,
                  const std::string& recorded);

}  // namespace simuli
