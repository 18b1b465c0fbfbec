#pragma once
// Ground truth of actors in a frame.
#include <memory>
#include <vector>

#include "host/core/scene/actor_label.hpp"
#include "host/device/render/scene/scene_on_device.hpp"

namespace simuli {

/// Tells who is in frames, and how much of them is seen.
class LabelsOnDevice {
 public:
  /// Of frames of that scene, rendered with those options (FrameRequest::options, else the scene's).
  LabelsOnDevice(const Device& device, std::shared_ptr<const Scene> scene, const RenderOptions& options = {});

  /// The actors that are there during the frame, in the order of Scene::actors. Each is rendered once more
  /// without what hides it. Waits. Error{kUsage} for a frame rendered without FrameRequest::actors.
  [[nodiscard]] std::vector<ActorLabel> of(const Frame& frame);

 private:
  std::shared_ptr<const Scene> scene_;
  SceneOnDevice alone_;  // actors without anything around them
};

}  // namespace simuli
