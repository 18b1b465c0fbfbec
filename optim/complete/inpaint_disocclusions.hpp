#pragma once
// Separates and inpaints disocclusions: background behind actors that no frame shows.
#include "host/device/render/options/options.hpp"
#include "host/device/runtime/device.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/init/init_options.hpp"

namespace simuli {

/// Options with which the scene was trained.
struct InpaintRecipe {
  FrameSelection frames;  // training frames
  InitOptions init;  // of the initialisation
  RenderOptions render;
};

/// Moves background particles of a trained scene that only show in rays through an actor to that actor's
/// disoccluded set (Scene::occluders, owners_during()), and fills rays that would then hit nothing by an
/// inpainted set: each row of pixels or firings continues the surfaces next to the gap (inpaint_rows()).
/// Recorded views keep their bits: both sets differ only while an actor is elsewhere. Does nothing without
/// actors. Throws Error{kDevice} when the device lacks memory.
void inpaint_behind_actors(const Device& device, const Log& log, const InpaintRecipe& recipe, SceneFile& scene);

}  // namespace simuli
