#pragma once
// Conversion of scene edits from messages.
#include <cstdint>

#include "host/apps/serve/messages/camera_message.hpp"
#include "host/apps/serve/session/served_scene.hpp"

namespace simuli::serve {

/// Applies first the replacements, then the insertions, each in order and on the result of the previous ones. A
/// replaced actor keeps its name, its track and its ground position. An inserted actor has the particles of
/// `asset_id`, an actor of the scene, and the message's trajectory, or else the asset's track; a size scales it
/// uniformly. Throws Refusal{kInvalid} naming the field, also when the edit is applied; Refusal{kOutOfRange}
/// for times; Refusal{kExhausted} for more than `most_more` particles beyond twice those of the scene as it was
/// read.
[[nodiscard]] SceneEdit edit_of(const ServedScene& scene,
                                const proto::EditAssetsRequest& request,
                                std::int64_t most_more);

}  // namespace simuli::serve
