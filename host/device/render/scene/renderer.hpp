#pragma once
#include <memory>
#include <vector>

#include "host/device/render/scene/pass.hpp"
#include "host/device/render/scene/view.hpp"

namespace simuli {

class ParticlePages;  // host/device/render/pages/particle_pages.hpp

/// Renders one particle set for one sensor, one frame at a time.
class Renderer {
 public:
  /// Throws Error{kUsage} for options that validate() refuses.
  Renderer(const Device& device, const RenderOptions& options);
  Renderer(Renderer&&) noexcept = default;
  Renderer& operator=(Renderer&&) noexcept = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  ~Renderer() = default;

  /// Forward pass: project, sort, bin, blend, composite over the environment if given (cameras; the view's
  /// background then shows only in pixels without a ray). Results stay on the device. Throws Error{kUsage} for
  /// rays or particles made with other options, for fewer actors in the view than the particles' owners, and
  /// for an environment with a LiDAR.
  Pass render(const ParticleBuffers& particles,
              const SensorRays& rays,
              const View& view,
              const EnvironmentBuffers* environment = nullptr);

  /// Forward pass with paged particles, loading those that the frame may see. Throws as ParticlePages::bring().
  Pass render(ParticlePages& particles,
              const SensorRays& rays,
              const View& view,
              const EnvironmentBuffers* environment = nullptr);

  /// Moves particles of actors back into their boxes; `actors` of the scene, in order.
  void confine(ParticleBuffers& particles, const std::vector<Actor>& actors, double margin_m);

  [[nodiscard]] const RenderOptions& options() const;
  [[nodiscard]] const Device& device() const;

 private:
  Pass render(const ParticleBuffers& particles,
              ParticlePages* pages,
              const SensorRays& rays,
              const View& view,
              const EnvironmentBuffers* environment);
  std::shared_ptr<Pass::State> state_;
};

}  // namespace simuli
