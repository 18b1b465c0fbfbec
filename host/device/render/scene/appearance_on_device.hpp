#pragma once
#include <memory>
#include <string>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/renderer.hpp"

namespace simuli {

/// What a trained scene adds to the pictures of its camera set: environment and colour grids, where it has
/// them.
class AppearanceOnDevice {
 public:
  /// `scene` must outlive it.
  AppearanceOnDevice(const Device& device, const Scene& scene, Precision precision);

  /// Renders the camera set as `camera` sees it at time_s (of the log): through the grid that
  /// ColorGrids::at gives, and none for cameras that were not trained on. No name: colours are those that all
  /// pictures share.
  template <class Particles>  // ParticleBuffers, ParticlePages
  Pass render(Renderer& renderer,
              Particles& camera_set,
              const SensorRays& rays,
              const View& view,
              const std::string& camera,
              double time_s) {
    return graded(renderer.render(camera_set, rays, view, environment_.get()), camera, time_s);
  }

 private:
  Pass graded(Pass pass, const std::string& camera, double time_s);

  Device device_;
  const Scene& scene_;
  Precision precision_;
  std::unique_ptr<EnvironmentBuffers> environment_;
};

}  // namespace simuli
