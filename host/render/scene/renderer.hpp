#pragma once
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "host/render/backward/backward_options.hpp"
#include "host/render/backward/gradient_buffers.hpp"
#include "host/render/backward/pose_gradient.hpp"
#include "host/render/frame/frame_buffers.hpp"
#include "host/render/frame/particle_buffers.hpp"
#include "host/render/frame/picture_buffers.hpp"
#include "host/render/rays/ray_buffers.hpp"
#include "host/render/scene/ray_results.hpp"
#include "host/render/scene/view.hpp"
#include "host/render/train/actor.hpp"
#include "host/render/train/losses.hpp"
#include "host/scene/actor.hpp"
#include "host/scene/pose.hpp"

namespace simuli {

struct Variant;
struct RayMapSizes {
  std::uint64_t slots = 0;
  std::uint64_t rays = 0;
};
/// The map between slots and rays on the device.
struct RayMap : BufferTable<RayMapSizes> {
  RayMap(const Device& device, const RayGrid& grid);
  /// [slots], -1: none.
  Array<std::int32_t> ray_of_slot{*this, "ray_of_slot", [](const RayMapSizes& s) { return s.slots; }};
  /// [rays], -1: none, of a pixel that the lens sees nothing through.
  Array<std::int32_t> slot_of_ray{*this, "slots_of_map", [](const RayMapSizes& s) { return s.rays; }};
};

/// A sensor ready to render: its ray grid, on host and device. A handle: copies refer to the same rays, and a
/// Renderer keeps those of its last frame alive, so that a temporary may be rendered.
class SensorRays {
 public:
  SensorRays(const Device& device, const Camera& camera, const RenderOptions& options);
  /// Rays in the LiDAR's blind arcs are never rendered.
  SensorRays(const Device& device,
             const LidarModel& lidar,
             const LidarRays& rays,
             const RenderOptions& options);

  /// From now on only the rays with requested[ray] are rendered; the others are slots without a ray, and
  /// their results the background. requested[rays]; empty: all. A LiDAR's ray mask is rebuilt. Waits, unless
  /// that is so already.
  void request(const std::vector<bool>& requested);

  [[nodiscard]] const RayGrid& grid() const { return state_->grid; }
  /// Whether there is a ray mask, and whether it has a cell without a ray.
  [[nodiscard]] bool marked() const { return state_->marks; }
  [[nodiscard]] bool can_cull() const { return state_->can_cull; }
  [[nodiscard]] const RayBuffers& buffers() const { return state_->buffers; }
  /// The map between slots and rays on the device, made when first asked for.
  [[nodiscard]] const RayMap& map() const;
  /// Device memory, and as much on the host.
  [[nodiscard]] std::size_t bytes() const;
  /// values[channels][rays] in ray order -> [channels][slots] in slot order; slots without a ray get 0.
  [[nodiscard]] std::vector<float> to_slots(const std::vector<float>& values, std::size_t channels) const;

 private:
  struct State {
    State(const Device& device, RayGrid rays, const RenderOptions& options);
    void mark_rays(RayMaskSize size);
    void place_requested();
    Device device;
    Precision precision;
    bool marks;  // a LiDAR's that culls
    RayMaskSize mask_size;
    std::vector<bool> blind;      // [rays] of a LiDAR with blind arcs, else empty
    std::vector<bool> requested;  // [rays]; empty: all that there are
    std::optional<RayMap> map;
    RayGrid grid;
    RayBuffers buffers;
    bool can_cull = false;
  };
  SensorRays(const Device& device, RayGrid grid, const RenderOptions& options);
  std::shared_ptr<State> state_;
};

struct PictureBuffers : BufferTable<FrameSizes> {
  using BufferTable::BufferTable;
  Reals picture{*this, "picture", [](const FrameSizes& s) { return 3 * s.slots; }};  // [3][S], graded
};

/// Renders one particle set, and takes gradients back to it. One frame at a time; the buffers of the last
/// frame stay readable until the next.
class Renderer {
 public:
  Renderer(const Device& device, const RenderOptions& options);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  ~Renderer();

  /// Forward pass: project, sort, bin, blend, over the environment when one is given (cameras; the view's
  /// background is then seen by pixels without a ray alone). Results stay on the device.
  void render(const ParticleBuffers& particles,
              const SensorRays& rays,
              const View& view,
              const EnvironmentBuffers* environment = nullptr);
  /// Whether pictures have median distances from now on; sweeps have them as the options say.
  void want_camera_median(bool wanted) { camera_median_ = wanted; }
  /// The camera's last render through grid `index`: what results() and image_loss() then see.
  void grade(const ColorGridBuffers& grids, std::size_t index);
  /// Results of the last render, in ray order. Waits.
  [[nodiscard]] RayResults results() const;

  /// What the last render wrote changes hands: the caller has it from now on, and the next render writes to
  /// `outputs` and `picture`. results() then waits for that render.
  void exchange_outputs(RealBuffer& outputs, RealBuffer& picture);
  /// What results() need beside the outputs.
  [[nodiscard]] bool has_median() const { return median_; }
  [[nodiscard]] bool is_graded() const { return graded_; }

  /// Losses of the last render; they leave dL/d(outputs) for backward(). truth in slot order.
  ImageLoss image_loss(const RealBuffer& truth, const ImageLossScale& scale);
  LidarLoss lidar_loss(const RealBuffer& truth, const LidarLossScale& scale);
  /// [3][slots] in slot order: the picture of the last render, graded when it has been.
  [[nodiscard]] const RealBuffer& picture() const {
    return graded_ ? pictures_.picture : buffers_.blended.out;
  }
  /// dL/d(outputs)[5][slots] given directly: features, transmittance, sum of w tau.
  void set_output_gradients(const std::vector<double>& gradients);
  /// dL/d(graded picture) -> dL/d(outputs) and grid_grads[reals] of grid `index`; before the other two.
  void grade_backward(const ColorGridBuffers& grids,
                      std::size_t index,
                      const ColorGridScale& scale,
                      RealBuffer& grid_grads);
  /// dL/d(outputs) -> texture_grads[height][width][4], and tv_scale times that of the total variation.
  void environment_backward(const EnvironmentBuffers& environment,
                            double tv_scale,
                            RealBuffer& texture_grads);
  /// dL/d(outputs) -> param_grads[param_rows][stride] of the particles last rendered, and the extras.
  void backward(const ParticleBuffers& particles, RealBuffer& param_grads, const BackwardExtras& extras = {});
  /// After backward with ray gradients: dL/d(pose) of the sensor last rendered, from those and param_grads.
  /// Waits.
  [[nodiscard]] PoseGradient pose_gradient(const RealBuffer& param_grads);

  /// dL/d(poses of the actors) of the last backward(), in the order of View::actors. Waits.
  [[nodiscard]] std::vector<ActorPoseGradient> pose_gradients(const ParticleBuffers& particles) {
    return actors_.pose_gradients(particles, buffers_.projected, gradients_, actor_motion_);
  }
  /// Puts particles of actors back into their boxes; `actors` of the scene, in its order.
  void confine(ParticleBuffers& particles, const std::vector<Actor>& actors, double margin_m) {
    actors_.confine(particles, actors, margin_m);
  }

  [[nodiscard]] const FrameBuffers& buffers() const { return buffers_; }
  [[nodiscard]] const GradientBuffers& gradients() const { return gradients_; }
  [[nodiscard]] GradientBuffers& gradients() { return gradients_; }
  [[nodiscard]] const shared::FrameParams& frame() const { return frame_; }
  [[nodiscard]] const RenderOptions& options() const { return options_; }
  [[nodiscard]] const Device& device() const { return device_; }

 private:
  struct Stages;     // of one variant
  struct AllStages;  // what is common, and those of all variants so far
  Stages& stages_of(const Variant& variant);
  void need_picture() const;

  Device device_;
  RenderOptions options_;
  std::unique_ptr<AllStages> all_;
  FrameBuffers buffers_;
  GradientBuffers gradients_;
  ActorStage actors_;
  PictureBuffers pictures_;
  shared::FrameParams frame_{};
  std::optional<SensorRays> rays_;  // of the last frame
  Stages* current_ = nullptr;
  bool median_ = false;
  bool camera_median_ = false;
  bool graded_ = false;
  bool actor_motion_ = false;
  std::array<float, 3> background_{};
};

}  // namespace simuli
