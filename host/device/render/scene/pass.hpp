#pragma once
// One rendered frame: what is read of it and what gradients are taken through it.
#include <cstdint>
#include <memory>
#include <vector>

#include "host/device/render/backward/backward_options.hpp"
#include "host/device/render/backward/deform_bwd.hpp"
#include "host/device/render/backward/gradient_buffers.hpp"
#include "host/device/render/frame/frame_buffers.hpp"
#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/render/frame/picture_buffers.hpp"
#include "host/device/render/scene/ray_results.hpp"
#include "host/device/render/scene/sensor_rays.hpp"
#include "host/device/render/train/actor.hpp"
#include "host/device/render/train/losses.hpp"
#include "host/device/render/train/seen_surfaces.hpp"

namespace simuli {

struct Variant;  // host/device/render/frame/variant.hpp

/// What Renderer::render() has left on the device, until the renderer's next frame takes its place: every
/// call on an earlier pass is Error{kUsage}, as is every call out of order or with other things than were
/// rendered. A handle that keeps all it needs alive but for the particles: these, textures and grids are the
/// caller's.
///
/// Training: render, grade, a loss, grade_backward, environment_backward, backward, pose_gradients; each of
/// them only where it has been asked for, in this order.
class Pass {
 public:
  /// The picture through grid `index`: what results() and image_loss() then see. Of cameras, once.
  void grade(const ColorGridBuffers& grids, std::size_t index);
  /// In ray order. Waits.
  [[nodiscard]] RayResults results() const;
  /// What the pass wrote changes hands, and the pass ends: the caller has it from now on, and the next one
  /// writes to `outputs` and, graded, `picture`.
  void exchange_outputs(RealBuffer& outputs, RealBuffer& picture);

  /// Of a LiDAR: the drop function that losses see from here on; what the pass wrote stays.
  void set_drop(const RayDrop::Parameters& drop);

  /// Losses of what results() shows; they leave its gradient for what follows. truth: three channels of
  /// colour in [0, 1] (negative: not known); or range (m, negative: not known, 0: no return) and intensity.
  ImageLoss image_loss(const RayValues& truth, const ImageLossScale& scale);
  LidarLoss lidar_loss(const RayValues& truth, const LidarLossScale& scale);
  /// dL/d(what results() shows) given directly, [5][rays] in ray order: features, transmittance, distance.
  void set_output_gradients(const std::vector<double>& gradients);

  /// dL/d(graded picture) -> dL/d(picture) and grid_grads[reals] of the grid that it was graded by.
  void grade_backward(const ColorGridBuffers& grids,
                      std::size_t index,
                      const ColorGridScale& scale,
                      RealBuffer& grid_grads);
  /// -> texture_grads[height][width][4] of the environment rendered, and tv_scale times that of the total
  /// variation.
  void environment_backward(const EnvironmentBuffers& environment,
                            double tv_scale,
                            RealBuffer& texture_grads);
  /// -> param_grads[param_rows][stride] of the particles rendered, 0 for those that the frame culled; and the
  /// extras. With options that need_gradients() takes; a median distance takes part in none.
  void backward(const ParticleBuffers& particles, RealBuffer& param_grads, const BackwardExtras& extras = {});
  /// dL/d(poses of the actors) of the last backward(), in the order of View::actors. Waits.
  [[nodiscard]] std::vector<ActorPoseGradient> pose_gradients(const ParticleBuffers& particles);

  /// dL/d(shapes of the actors) of the last backward(), in the order of View::actors; empty where all that
  /// are there are rigid. Waits.
  [[nodiscard]] std::vector<DeformationGradient> deformation_gradients();

  /// Raises largest[N] of the particles rendered to the largest weight that each has in a ray of this pass:
  /// bits of floats, which rise as these do. In order of range, also where rays have orders of their own.
  void raise_largest_weights(Buffer<std::uint32_t>& largest);

  /// Of a camera's frame of surfaces: from where and how far away they were seen goes to `seen`, and the pass
  /// ends.
  void keep_surfaces(SeenSurfaces& seen);
  /// Of a camera's frame of surfaces, beside one of the same camera that was kept and has recorded
  /// `picture`: what the picture shows of what each ray meets, -1 where it shows something else there, or
  /// nothing. Surfaces let a fifth of the light through at most. Of rays that meet nothing: the one colour
  /// that the picture shows of all places along them from 4 m on, if it is one (METHOD section 10).
  void show_from(const SeenSurfaces& recorded, const RayValues& picture, RayValues& shown);

  /// The sensor; grid().ray_of_slot is the map from the device's order to that of rays (-1: no ray).
  [[nodiscard]] const SensorRays& rays() const;
  /// What stands on the device, in slot order.
  [[nodiscard]] const shared::FrameParams& frame() const;
  /// What its kernels were specialised for.
  [[nodiscard]] const Variant& variant() const;
  [[nodiscard]] const FrameBuffers& buffers() const;
  [[nodiscard]] const GradientBuffers& gradients() const;
  /// [3][slots]: the picture, graded when it has been.
  [[nodiscard]] const RealBuffer& picture() const;
  /// The picture has been graded; there are medians in the outputs.
  [[nodiscard]] bool is_graded() const;
  [[nodiscard]] bool has_median() const;
  /// [slots], to be filled: the errors that backward() with `errors` shares out among particles.
  [[nodiscard]] RealBuffer& ray_error();

 private:
  friend class Renderer;
  struct State;  // of the renderer
  Pass(std::shared_ptr<State> state, std::uint64_t number) : state_(std::move(state)), number_(number) {}
  [[nodiscard]] State& last(const char* call) const;
  std::shared_ptr<State> state_;
  std::uint64_t number_;
};

}  // namespace simuli
