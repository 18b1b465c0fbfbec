#pragma once
// One rendered frame: its results and the gradients through it.
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

/// The result of Renderer::render() on the device, valid until the renderer's next frame: calls on earlier
/// passes, in the wrong order or with other data than rendered throw Error{kUsage}. A handle that keeps its
/// inputs alive, except for particles, textures and grids, which belong to the caller.
///
/// Training calls render, grade, a loss, grade_backward, environment_backward, backward, pose_gradients in this
/// order; each is optional.
class Pass {
 public:
  /// Applies grid `index` to the picture; results() and image_loss() then use the corrected picture. Cameras
  /// only, once.
  void grade(const ColorGridBuffers& grids, std::size_t index);
  /// Returns the results in ray order. Waits.
  [[nodiscard]] RayResults results() const;
  /// Exchanges the output buffers with the caller's and ends the pass; the renderer uses `outputs` and, with
  /// colour grid, `picture` for its next frame.
  void exchange_outputs(RealBuffer& outputs, RealBuffer& picture);

  /// Sets the ray-drop function of a LiDAR for subsequent losses; does not change the outputs.
  void set_drop(const RayDrop::Parameters& drop);

  /// Computes the loss of results() and stores its gradient. truth: three colour channels in [0, 1] (negative:
  /// unknown); or range (m, negative: unknown, 0: no return) and intensity.
  ImageLoss image_loss(const RayValues& truth, const ImageLossScale& scale);
  LidarLoss lidar_loss(const RayValues& truth, const LidarLossScale& scale);
  /// Sets dL/d(results()) directly, [5][rays] in ray order: features, transmittance, distance.
  void set_output_gradients(const std::vector<double>& gradients);

  /// Backpropagates dL/d(corrected picture) to dL/d(picture) and grid_grads[reals] of the applied grid.
  void grade_backward(const ColorGridBuffers& grids,
                      std::size_t index,
                      const ColorGridScale& scale,
                      RealBuffer& grid_grads);
  /// Computes texture_grads[height][width][4] of the rendered environment, plus tv_scale times the gradient of
  /// its total variation.
  void environment_backward(const EnvironmentBuffers& environment,
                            double tv_scale,
                            RealBuffer& texture_grads);
  /// Computes param_grads[param_rows][stride] of the rendered particles, 0 for culled ones, and the optional
  /// outputs. Requires options that need_gradients() accepts; median distances have no gradient.
  void backward(const ParticleBuffers& particles, RealBuffer& param_grads, const BackwardExtras& extras = {});
  /// Returns dL/d(actor poses) of the last backward(), in the order of View::actors. Waits.
  [[nodiscard]] std::vector<ActorPoseGradient> pose_gradients(const ParticleBuffers& particles);

  /// Returns dL/d(actor deformations) of the last backward(), in the order of View::actors; empty if all actors
  /// present are rigid. Waits.
  [[nodiscard]] std::vector<DeformationGradient> deformation_gradients();

  /// Raises largest[N] of the rendered particles to their largest weight in a ray of this pass, as float bits,
  /// which order like the values. Uses the order of range even for rays in their own order.
  void raise_largest_weights(Buffer<std::uint32_t>& largest);

  /// Stores the poses and surface distances of a camera's rendering of surfaces in `seen`, and ends the pass.
  void keep_surfaces(SeenSurfaces& seen);
  /// For a camera's off-trajectory rendering of surfaces, with a kept rendering of the same camera that
  /// recorded `picture`: colours each ray's surface from the picture, -1 where the picture shows another
  /// surface or nothing. Surfaces have a transmittance of at most a fifth. Rays without surface get the common
  /// colour of all points along them from 4 m on, if there is one (METHOD section 10).
  void show_from(const SeenSurfaces& recorded, const RayValues& picture, RayValues& shown);

  /// The sensor; grid().ray_of_slot maps the device's order to rays (-1: no ray).
  [[nodiscard]] const SensorRays& rays() const;
  /// Device data, in slot order.
  [[nodiscard]] const shared::FrameParams& frame() const;
  /// Specialisation of the pass's kernels.
  [[nodiscard]] const Variant& variant() const;
  [[nodiscard]] const FrameBuffers& buffers() const;
  [[nodiscard]] const GradientBuffers& gradients() const;
  /// [3][slots]: the picture, after the colour grid if applied.
  [[nodiscard]] const RealBuffer& picture() const;
  /// Whether the picture went through a colour grid; whether the outputs contain medians.
  [[nodiscard]] bool is_graded() const;
  [[nodiscard]] bool has_median() const;
  /// [slots], filled by the caller: the errors that backward() with `errors` distributes to particles.
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
