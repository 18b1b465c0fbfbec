#pragma once
// Ground truth of actors in a frame.
#include <memory>
#include <vector>

#include "host/core/scene/actor_label.hpp"
#include "host/device/render/scene/scene_on_device.hpp"

namespace simuli {

/// Computes labels of the actors in a frame: visibility, boxes and masks.
class LabelsOnDevice {
 public:
  /// For frames of `scene` rendered with these options (FrameRequest::options, else the scene's).
  LabelsOnDevice(const Device& device, std::shared_ptr<const Scene> scene, const RenderOptions& options = {});

  /// Returns labels of the actors present during the frame, in the order of Scene::actors. Renders each actor
  /// again without occluders. Waits. Throws Error{kUsage} for a frame rendered without FrameRequest::actors.
  [[nodiscard]] std::vector<ActorLabel> of(const Frame& frame);

 private:
  std::shared_ptr<const Scene> scene_;
  SceneOnDevice alone_;  // actors without other particles
};

}  // namespace simuli
