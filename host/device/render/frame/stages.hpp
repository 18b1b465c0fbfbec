#pragma once
// The contract of a frame: its stages in the order in which they run. Each is a launcher with the stem of its
// kernel file, gets the parts of the frame that it reads, and writes the last one that it is given. N
// particles, M of them visible, K tile pairs, S ray slots. For Renderer, training's stages and tests: who
// renders needs none of this.
#include <optional>

#include "host/device/render/device/sort.hpp"
#include "host/device/render/frame/frame_buffers.hpp"
#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/render/frame/picture_buffers.hpp"
#include "host/device/render/frame/variant.hpp"
#include "host/device/render/rays/ray_buffers.hpp"

namespace simuli {

/// 1. The rays of the sensor at their times. S -> S.
class RaysStage {
 public:
  RaysStage(const Device& device, const Variant& variant);
  void run(const shared::FrameParams& frame,
           const RayBuffers& rays,
           const FrameConstants& constants,
           WorldRays& out);

 private:
  int lanes_;
  std::size_t rows_;
  Kernel rays_;
};

/// 1b. Where an actor is not rigid: how far its particles are from where they belong. N -> N.
class DeformStage {
 public:
  DeformStage(const Device& device, Precision precision);
  /// deform_at and deform_shapes of `constants` -> their deform_offset.
  void run(const ParticleBuffers& particles, FrameConstants& constants);

 private:
  Kernel deform_;
};

/// What the Monte Carlo projection draws with, the same in every frame; empty for the others.
struct SampleSizes {
  std::uint64_t triples = 0;
};
struct SampleBuffers : BufferTable<SampleSizes> {
  using BufferTable::BufferTable;
  Reals normal_samples{*this, "normal_samples", [](const SampleSizes& s) { return 3 * s.triples; }};
};

/// 2. Particles on the sensor: which rays they may meet, and what blending needs of them. N -> N. Clusters of
/// them that the sensor cannot see are left out first.
class ProjectStage {
 public:
  ProjectStage(const Device& device, const Variant& variant);
  void run(const shared::FrameParams& frame,
           const ParticleBuffers& particles,
           const RayBuffers& rays,
           const FrameConstants& constants,
           Projected& out);

 private:
  int lanes_;
  bool actor_motion_;
  SampleBuffers samples_;
  Kernel cull_clusters_, project_;
};

/// 3. The visible particles by range, and of each tile those that its rays may meet. N -> M -> K.
class BinStage {
 public:
  /// `work_items` as SortStage.
  explicit BinStage(const Device& device, std::size_t work_items = 0);
  /// Error{kDevice} with numbers when the frame needs more than max_pairs. Waits once, for M and K.
  void run(const shared::FrameParams& frame,
           const ParticleBuffers& particles,
           const RayBuffers& rays,
           const Projected& projected,
           std::size_t max_pairs,
           Binned& out);

 private:
  void list_visible(const ParticleBuffers& particles,
                    const Projected& projected,
                    std::size_t max_pairs,
                    FrameSizes& sizes,
                    Binned& out);
  void list_pairs(const shared::FrameParams& frame,
                      const RayBuffers& rays,
                      const Projected& projected,
                      FrameSizes& sizes,
                      Binned& out);
  Device device_;
  std::size_t group_;  // work-items
  ScanStage scan_;
  SortStage sort_;
  BinScratch scratch_;
  Kernel visible_count_, visible_write_, pair_count_, pair_emit_, tile_ranges_;
};

/// 4. Each ray through its tile's list, front to back. K -> S.
class RenderStage {
 public:
  RenderStage(const Device& device, const Variant& variant);
  void run(const shared::FrameParams& frame,
           const ParticleBuffers& particles,
           const RayBuffers& rays,
           const FrameConstants& constants,
           const WorldRays& world_rays,
           const Projected& projected,
           const Binned& binned,
           Blended& out);

 private:
  std::size_t work_items_;
  std::uint64_t outputs_;          // rows of out
  Kernel render_;                  // of render.cl or render_window.cl
  std::optional<Kernel> per_ray_;  // what that leaves to be done exactly
};

/// 5. Of a camera with an environment: over black -> over the texture. S -> S.
class EnvironmentStage {
 public:
  /// `lanes` per work-item; 0: as suits the device. Tests run the GPU's way on CPUs.
  EnvironmentStage(const Device& device, Precision precision, int lanes = 0);
  void run(const shared::FrameParams& frame,
           const EnvironmentBuffers& environment,
           const FrameConstants& constants,
           const WorldRays& world_rays,
           Blended& out);

 private:
  int lanes_;
  Kernel environment_;
};

/// 6. Of a camera that is graded: out -> picture[3][S] through one of its bilateral grids.
class ColorGridStage {
 public:
  /// For grids of the sizes of `grids`.
  ColorGridStage(const Device& device, const ColorGridBuffers& grids);
  /// By grid `index`. width, height: of the picture, px.
  void run(const shared::FrameParams& frame,
           int width,
           int height,
           const ColorGridBuffers& grids,
           std::size_t index,
           const Blended& blended,
           RealBuffer& picture);

 private:
  Kernel color_grid_;
};

}  // namespace simuli
