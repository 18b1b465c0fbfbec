#pragma once
// The backward stages of a frame, in the opposite order of host/device/render/frame/stages.hpp. Each is a
// launcher with the stem of its kernel file. Losses write GradientBuffers::grad_out.
#include <optional>

#include "host/device/render/backward/backward_options.hpp"
#include "host/device/render/backward/gradient_buffers.hpp"
#include "host/device/render/frame/stages.hpp"

namespace simuli {

struct ColorGridGradientSizes {
  std::uint64_t rows = 0;          // of the picture
  std::uint64_t row_partials = 0;  // reals of one row partial
};
struct ColorGridScratch : BufferTable<ColorGridGradientSizes> {
  using BufferTable::BufferTable;
  Reals partial{
      *this, "color_grid_sums", [](const ColorGridGradientSizes& s) { return s.rows * s.row_partials; }};
};

/// Backward pass of a colour grid: grad_out of the corrected picture -> grad_out of the input picture,
/// grads[reals] of the grid.
class ColorGridBackwardStage {
 public:
  /// For grids of the same sizes as `grids`.
  ColorGridBackwardStage(const Device& device, const ColorGridBuffers& grids);
  void run(const shared::FrameParams& frame,
           int width,
           int height,
           const ColorGridBuffers& grids,
           std::size_t index,
           const ColorGridScale& scale,
           const Blended& blended,
           GradientBuffers& gradients,
           RealBuffer& grads);

 private:
  std::size_t columns_, row_items_;  // cells along x; work-items per row of pixels
  std::size_t vertices_, partial_reals_;  // vertices of a grid; reals per row of pixels
  ColorGridScratch scratch_;
  Kernel rows_, pixels_, gather_;
};

struct EnvironmentGradientSizes {
  std::uint64_t slots = 0;
  std::uint64_t cells = 0;
};
struct EnvironmentScratch : BufferTable<EnvironmentGradientSizes> {
  using BufferTable::BufferTable;
  Words cell{*this, "cell", [](const EnvironmentGradientSizes& s) { return s.slots; }};
  Words slot{*this, "slot", [](const EnvironmentGradientSizes& s) { return s.slots; }};
  Reals fraction{*this, "fraction", [](const EnvironmentGradientSizes& s) { return 2 * s.slots; }};
  Words first{*this, "cell_first", [](const EnvironmentGradientSizes& s) { return s.cells + 1; }};
};

/// Backward pass of the environment: out, grad_out -> grads[height][width][4], plus tv_scale times the gradient
/// of the total variation: squared differences between neighbours, horizontally divided by cos(elevation),
/// vertically multiplied by it.
class EnvironmentBackwardStage {
 public:
  /// `lanes` as in EnvironmentStage.
  EnvironmentBackwardStage(const Device& device, Precision precision, int lanes = 0);
  void run(const shared::FrameParams& frame,
           const EnvironmentBuffers& environment,
           double tv_scale,
           const FrameConstants& constants,
           const WorldRays& world_rays,
           const Blended& blended,
           const GradientBuffers& gradients,
           RealBuffer& grads);

 private:
  Device device_;
  int lanes_;
  SortStage sort_;
  EnvironmentScratch scratch_;
  Kernel cells_, ranges_, gather_;
};

/// Backward pass of blending: out, grad_out -> gradient slots, and the optional outputs. S -> K.
class RenderBackwardStage {
 public:
  RenderBackwardStage(const Device& device, const Variant& variant);
  void run(const shared::FrameParams& frame,
           const ParticleBuffers& particles,
           const RayBuffers& rays,
           const FrameBuffers& made,
           const BackwardExtras& extras,
           GradientBuffers& gradients);

 private:
  Kernel& kernel(const BackwardExtras& extras);
  void replay(const shared::FrameParams& frame,
              const ParticleBuffers& particles,
              const RayBuffers& rays,
              const FrameBuffers& made,
              std::uint32_t tile_first,
              std::size_t items,
              GradientBuffers& gradients);
  Device device_;
  Variant variant_;
  ScanStage scan_;
  std::optional<Kernel> replay_window_, replay_per_ray_;
  Kernel slot_counts_;
  std::optional<Kernel> kernels_[2];  // [errors], made on demand
};

/// Backward pass of projection: gradient slots -> param_grads[param_rows][stride], and pose_grads of actors; 0
/// for culled particles. K -> N.
class ProjectBackwardStage {
 public:
  ProjectBackwardStage(const Device& device, const Variant& variant);
  void run(const shared::FrameParams& frame,
           const ParticleBuffers& particles,
           const FrameBuffers& made,
           GradientBuffers& gradients,
           RealBuffer& param_grads);

 private:
  int lanes_;
  bool actors_;
  Kernel project_bwd_;
};

}  // namespace simuli
