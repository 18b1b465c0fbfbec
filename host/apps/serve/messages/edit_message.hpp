#pragma once
// Edits of a scene as messages say them.
#include <cstdint>

#include "host/apps/serve/messages/camera_message.hpp"
#include "host/apps/serve/session/served_scene.hpp"

namespace simuli::serve {

/// First the replacements, then the insertions, each in its order and on what those before it made. An actor
/// that is replaced keeps its name and its track, and stands where it stood. One that is inserted has the
/// particles of `asset_id`, an actor of the scene, and the trajectory of the message, or without one the
/// asset's; a size makes it larger or smaller as a whole. Refusal{kInvalid} naming the field, also from the
/// edit when it is applied; Refusal{kOutOfRange} for times, Refusal{kExhausted} for more than `most_more`
/// particles beyond twice those of the scene as it was read.
[[nodiscard]] SceneEdit edit_of(const ServedScene& scene,
                                const proto::EditAssetsRequest& request,
                                std::int64_t most_more);

}  // namespace simuli::serve
