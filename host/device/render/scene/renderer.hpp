#pragma once
#include <memory>
#include <vector>

#include "host/device/render/scene/pass.hpp"
#include "host/device/render/scene/view.hpp"

namespace simuli {

class ParticlePages;  // host/device/render/pages/particle_pages.hpp

/// Renders one particle set as one sensor sees it, a frame at a time.
class Renderer {
 public:
  /// Error{kUsage} for options that validate() refuses.
  Renderer(const Device& device, const RenderOptions& options);
  Renderer(Renderer&&) noexcept = default;
  Renderer& operator=(Renderer&&) noexcept = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  ~Renderer() = default;

  /// Forward pass: project, sort, bin, blend, over the environment when one is given (cameras; the view's
  /// background is then seen by pixels without a ray alone). Results stay on the device. Error{kUsage} for
  /// rays or particles made with other options, fewer actors in the view than the particles belong to, an
  /// environment behind a LiDAR.
  Pass render(const ParticleBuffers& particles,
              const SensorRays& rays,
              const View& view,
              const EnvironmentBuffers* environment = nullptr);

  /// The same of particles of which those come to the device that the frame may see. Errors of
  /// ParticlePages::bring().
  Pass render(ParticlePages& particles,
              const SensorRays& rays,
              const View& view,
              const EnvironmentBuffers* environment = nullptr);

  /// Puts particles of actors back into their boxes; `actors` of the scene, in its order.
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
