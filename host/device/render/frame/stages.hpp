#pragma once
// The stages of a frame in execution order. Each is a launcher with the stem of its kernel file, reads the
// buffers of earlier stages, and writes its last argument. N particles, M of them visible, K tile-Gaussian
// pairs, S ray slots. Used by Renderer, training stages and tests; rendering a scene does not need this header.
#include <optional>

#include "host/device/render/device/sort.hpp"
#include "host/device/render/frame/frame_buffers.hpp"
#include "host/device/render/frame/paper/normal_samples.hpp"
#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/render/frame/picture_buffers.hpp"
#include "host/device/render/frame/variant.hpp"
#include "host/device/render/rays/ray_buffers.hpp"

namespace simuli {

/// 1. Transforms the sensor's rays to the scene at their times. S -> S.
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

/// 1b. Offsets of particles of non-rigid actors. N -> N.
class DeformStage {
 public:
  DeformStage(const Device& device, Precision precision);
  /// deform_at and deform_shapes of `constants` -> deform_offset.
  void run(const ParticleBuffers& particles, FrameConstants& constants);

 private:
  Kernel deform_;
};

/// 2. Projects particles: bounds on the sensor and blending records. Culls invisible clusters first. N -> N.
class ProjectStage {
 public:
  ProjectStage(const Device& device, const Variant& variant);
  /// Returns the kernel file for an extent.
  [[nodiscard]] static const char* file(Extent extent);
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

/// 3. Sorts visible particles by range and lists each tile's pairs. N -> M -> K.
class BinStage {
 public:
  /// `work_items` as in SortStage.
  explicit BinStage(const Device& device, std::size_t work_items = 0);
  /// Throws Error{kDevice} with the numbers when the frame exceeds max_pairs. Waits once, for M and K.
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

/// 4. Blends each ray along its tile's list, front to back. K -> S.
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
  std::optional<Kernel> per_ray_;  // renders the vectors left by render_
};

/// 5. Cameras with an environment: composites features over black onto the texture. S -> S.
class EnvironmentStage {
 public:
  /// `lanes` per work-item; 0: chosen for the device. Tests run the GPU configuration on CPUs.
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

/// 6. Cameras with colour grids: out -> picture[3][S] through one of the grids.
class ColorGridStage {
 public:
  /// For grids of the same sizes as `grids`.
  ColorGridStage(const Device& device, const ColorGridBuffers& grids);
  /// Applies grid `index`. width, height: of the picture, px.
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
