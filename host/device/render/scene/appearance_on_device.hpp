#pragma once
#include <memory>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "host/device/render/scene/shot.hpp"

namespace simuli {

/// The appearance of a trained scene's pictures: environment map and colour grids, where it has them.
class AppearanceOnDevice {
 public:
  /// `scene` must outlive this object.
  AppearanceOnDevice(const Device& device, const Scene& scene, Precision precision);

  /// Renders the camera set as seen by `camera` during the shot, with the grid that ColorGrids::at selects.
  /// Null: without colour grid.
  template <class Particles>  // ParticleBuffers, ParticlePages
  Pass render(Renderer& renderer,
              Particles& camera_set,
              const SensorRays& rays,
              const View& view,
              const Camera* camera,
              const Shot& shot) {
    return graded(renderer.render(camera_set, rays, view, environment_.get()), camera, shot);
  }

 private:
  Pass graded(Pass pass, const Camera* camera, const Shot& shot);

  Device device_;
  const Scene& scene_;
  Precision precision_;
  std::unique_ptr<EnvironmentBuffers> environment_;
};

}  // namespace simuli
