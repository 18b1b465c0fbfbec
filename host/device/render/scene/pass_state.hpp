#pragma once
// State of a renderer that its passes share (renderer.cpp, pass.cpp).
#include <array>
#include <map>
#include <memory>
#include <optional>

#include "host/device/render/backward/backward_stages.hpp"
#include "host/device/render/backward/deform_bwd.hpp"
#include "host/device/render/frame/shapes_in_frame.hpp"
#include "host/device/render/frame/stages.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "host/device/render/train/off_trajectory.hpp"
#include "host/device/render/train/largest_weight.hpp"
#include "host/device/render/train/loss_stages.hpp"

namespace simuli {

struct Pass::State {
  struct Stages {
    Stages(const Device& device, const Variant& variant)
        : rays(device, variant), project(device, variant), render(device, variant), own(variant) {}
    RaysStage rays;
    ProjectStage project;
    RenderStage render;
    // Made on demand.
    std::optional<RenderBackwardStage> render_back;
    std::optional<ProjectBackwardStage> project_back;
    std::optional<LargestWeightStage> largest_weight;
    std::optional<OffTrajectoryStage> off_trajectory;
    Variant own;
  };
  /// Stages for grids of one size.
  struct ColorGrid {
    ColorGridStage forward;
    std::optional<ColorGridBackwardStage> back;  // made on demand
  };
  /// The variable whose gradient is in grad_out.
  enum class Gradient { kNone, kOfGraded, kOfOutputs };
  /// The last frame and its progress.
  struct Frame {
    std::optional<SensorRays> rays;
    Stages* stages = nullptr;
    shared::FrameParams params{};
    shared::SensorConstants<double> sensor{};
    std::array<float, 3> background{};
    std::uint64_t particles = 0;                      // their id()
    const EnvironmentBuffers* environment = nullptr;  // only compared
    bool paged = false;
    bool graded = false;
    Gradient gradient = Gradient::kNone;
    ShapesInFrame shapes{};
    bool has_ray_error = false, went_back = false;
  };

  State(const Device& on, const RenderOptions& wanted);
  Stages& stages(const FrameKind& kind);
  ColorGrid& grid_stages(const ColorGridBuffers& of);
  // Preconditions of calls; throw Error{kUsage}.
  void need_grid(const char* call, const ColorGridBuffers& of, std::size_t index) const;
  void need_truth(const char* call, const RayValues& truth, std::size_t channels) const;
  void need_gradient(const char* call) const;
  void need_particles(const char* call, const ParticleBuffers& particles) const;
  /// Marks grad_out as the gradient of the displayed picture.
  void has_gradient() { frame.gradient = frame.graded ? Gradient::kOfGraded : Gradient::kOfOutputs; }
  [[nodiscard]] const RealBuffer& shown() const {
    return frame.graded ? pictures.picture : buffers.blended.out;
  }

  Device device;
  RenderOptions options;
  std::map<FrameKind, std::unique_ptr<Stages>> all_stages;
  BinStage bin;
  ImageLossStage image_loss;
  LidarLossStage lidar_loss;
  // Made on demand.
  std::optional<DeformStage> deform;
  std::optional<DeformBackwardStage> deform_back;
  std::optional<EnvironmentStage> environment;
  std::optional<EnvironmentBackwardStage> environment_back;
  std::map<std::array<int, 3>, ColorGrid> grids;
  FrameBuffers buffers;
  GradientBuffers gradients;
  ActorStage actors;
  PictureBuffers pictures;
  std::uint64_t frames = 0;
  Frame frame;
};

}  // namespace simuli
