#pragma once
// What stood behind actors and was never seen: told apart from what was, and filled from around.
#include "host/device/render/options/options.hpp"
#include "host/device/runtime/device.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/init/init_options.hpp"

namespace simuli {

/// How the scene was trained.
struct InpaintRecipe {
  FrameSelection frames;  // from which it has learned
  InitOptions init;       // that made its first particles
  RenderOptions render;
};

/// Background particles of a trained scene that show in rays that meet an actor, were actors not there, and
/// in no others, go behind that actor (Scene::occluders, owners_during()); and what rays then meet nothing is
/// filled by particles of its own: each row of pixels, and of a LiDAR's beam, goes on from what is beside the
/// gap (inpaint_rows()). Recorded views stay as they are: both only differ while an actor is elsewhere. Nothing
/// happens without actors. Error{kDevice} when the device has no room.
void inpaint_behind_actors(const Device& device, const Log& log, const InpaintRecipe& recipe, SceneFile& scene);

}  // namespace simuli
