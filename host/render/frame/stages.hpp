#pragma once
// The contract of a frame: its stages in the order in which they run, each a launcher with the stem of its
// kernel file. N particles, M of them visible, K tile instances, S ray slots.
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "cl/shared/layout.h"
#include "host/render/options/options.hpp"
#include "host/render/rays/ray_grid.hpp"
#include "host/runtime/kernel.hpp"
#include "host/scene/gaussians.hpp"

namespace simuli {

template <>
struct ClTypeName<shared::FrameParams> {
  static constexpr std::string_view value = "FrameParams";
};
template <>
struct ClTypeName<shared::Footprint> {
  static constexpr std::string_view value = "Footprint";
};
template <>
struct ClTypeName<shared::SensorConstants<double>> {
  static constexpr std::string_view value = "SensorConstants";
};
template <>
struct ClTypeName<shared::ActorConstants<double>> {
  static constexpr std::string_view value = "ActorConstants";
};
using BufSensor = BufStructConst<shared::SensorConstants>;
using BufActors = BufStructConst<shared::ActorConstants>;

/// What kernels are specialised for. What a frame doesn't need compiles to nothing.
struct Variant {
  SensorType sensor = SensorType::kCamera;
  LensKind lens = LensKind::kPinhole;  // of a camera
  bool moving = false;                 // the pose changes during the frame
  bool origins = false;                // rays have origins of their own: moving, or lever arms
  bool actors = false;                 // particles belong to actors
  bool actor_motion = false;           // actors move during the frame: then `moving` and `origins`, too
  int sh_degree = 0;
  ShStorage sh_storage = ShStorage::kFull;
  bool median = false;
  Precision precision = Precision::kFloat;
  Projection projection = Projection::kUnscented;
  Extent extent = Extent::kUnscented;
  Order order = Order::kRange;
  ShDirection sh_direction = ShDirection::kParticle;
  Math math = Math::kFast;
  int shutter_iterations = 4;
  bool compensation = false;
  bool culling = false;  // by the ray mask
  LaneShape shape;

  [[nodiscard]] BuildOptions options() const;
  auto operator<=>(const Variant&) const = default;
};

/// How many work-items share a pass over n elements, and how many consecutive elements each takes.
struct Chunks {
  std::size_t work_items = 0;
  std::uint32_t chunk = 0;
};
[[nodiscard]] Chunks chunks_of(const Device& device, std::size_t n);

/// Rays of a sensor on the device (a RayGrid uploaded).
struct RayBuffers {
  RayBuffers(const Device& device, const RayGrid& grid, Precision precision);
  RealBuffer sensor_ray;  // [7][S]
  RealBuffer u;           // [S]
  Buffer<std::int32_t> row_lut;
  RealBuffer row_elevation;               // [2][rows]
  Buffer<std::uint32_t> tile_rows;        // [tiles_y + 1]
  Buffer<std::uint32_t> tile_row_of_row;  // [rows]
  Buffer<std::uint32_t> column_of_bin;    // [bins]
  Buffer<std::uint32_t> mask_row_of_row;  // [rows] of the ray mask
  Buffer<std::uint32_t> areas;            // [mask rows + 1][mask columns + 1] occupied cells above and left
};

/// Particles of one set on the device, each parameter a row of `stride` reals.
struct ParticleBuffers {
  ParticleBuffers(const Device& device, const GaussianSet& set, Precision precision);
  /// Only the bands of spherical harmonics that options.sh_degree keeps take memory, as options.sh_storage
  /// says. Error{kUsage} when halves are asked for in double, or cannot hold a coefficient (beyond 65504).
  ParticleBuffers(const Device& device, const GaussianSet& set, const RenderOptions& options);
  void upload(const GaussianSet& set);
  [[nodiscard]] GaussianSet download() const;
  SetKind kind;
  int sh_degree = 0;
  ShStorage sh_storage = ShStorage::kFull;
  std::uint32_t count = 0;
  std::uint32_t stride = 0;
  /// Another number for each: a pass takes gradients to the particles that it rendered alone.
  [[nodiscard]] std::uint64_t id() const { return id_; }
  RealBuffer
      params;  // [param_rows][stride]; of ShStorage::kHalf the rows from SIM_SH on are halves, two in a float
  /// GaussianSet::actor. All empty without actors.
  std::uint32_t actors = 0;           // the largest number in actor_of
  Buffer<std::uint32_t> actor_of;     // [stride]
  Buffer<std::uint32_t> actor_list;   // particles of actors, those of an actor consecutive
  Buffer<std::uint32_t> actor_first;  // [actors + 1], of each in the list
  /// After actor_of changed on the device (particles relocated or added): the other members again. Waits.
  void refresh_actors();

 private:
  std::uint64_t id_;
  ShDegree kept_sh_ = ShDegree::k3;
  double sh_error_ = 0.0;
  void upload_actors(const std::vector<std::uint32_t>& actor);
};

/// Everything a frame writes; grows, never shrinks.
struct FrameBuffers {
  FrameBuffers(const Device& device, Precision precision);
  RealBuffer sensor;                        // SensorConstants
  RealBuffer actors;                        // [1 + A] ActorConstants
  RealBuffer world_ray;                     // [3|6|7][S]
  RealBuffer records;                       // [N][16]
  RealBuffer motions;                       // [N][4], of particles whose actor moves
  Buffer<shared::Footprint> footprints;     // [N]
  Buffer<std::uint32_t> keys;               // [N]
  Buffer<std::uint32_t> order, order_keys;  // [M], by range
  Buffer<std::uint32_t> emission;           // [N]
  Buffer<std::uint32_t> tile, payload;      // [K], by tile, nearest first
  Buffer<std::uint32_t> first;              // [tiles + 1]
  RealBuffer out;                           // [6][S]
  RealBuffer grad_out;                      // [5][S]
  RealBuffer grads;                         // [K][16]
  RealBuffer ray_error, instance_error;     // [S], [K]: backward with errors
  RealBuffer ray_grads;                     // [3|6][S]: backward with ray gradients
  RealBuffer pose_grads;                    // [6][stride], of particles of actors
  Buffer<std::uint32_t> counts;             // scratch of the counting passes
  Buffer<std::uint32_t> key_scratch, value_scratch;
  std::uint32_t visible = 0;    // M
  std::uint32_t instances = 0;  // K
};

class RaysStage {
 public:
  RaysStage(const Device& device, const Variant& variant);
  void run(const shared::FrameParams& frame, const RayBuffers& rays, FrameBuffers& buffers);  // S -> S

 private:
  int lanes_;
  std::size_t rows_;
  Kernel<shared::FrameParams, BufSensor, BufRealConst, BufReal> rays_;
};

class ProjectStage {
 public:
  ProjectStage(const Device& device, const Variant& variant);
  void run(const shared::FrameParams& frame,
           const ParticleBuffers& particles,
           const RayBuffers& rays,
           FrameBuffers& buffers);  // N -> N
  /// Gradient slots -> param_grads[param_rows][stride].
  void run_backward(const shared::FrameParams& frame,
                    const ParticleBuffers& particles,
                    FrameBuffers& buffers,
                    RealBuffer& param_grads);

 private:
  int lanes_;
  bool actors_, actor_motion_;
  RealBuffer normal_samples_;  // [SIM_MONTE_CARLO][3] where the projection asks for them
  Kernel<shared::FrameParams,
         BufRealConst,
         Buf<const std::uint32_t>,
         BufActors,
         BufSensor,
         Buf<const std::int32_t>,
         BufRealConst,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         BufRealConst,
         BufReal,
         Buf<shared::Footprint>,
         Buf<std::uint32_t>,
         BufReal>
      project_;
  Kernel<shared::FrameParams,
         BufRealConst,
         Buf<const std::uint32_t>,
         BufActors,
         BufSensor,
         Buf<const std::uint32_t>,
         Buf<const shared::Footprint>,
         Buf<const std::uint32_t>,
         BufRealConst,
         BufRealConst,
         BufRealConst,
         BufReal,
         BufReal>
      project_bwd_;
};

class ScanStage {
 public:
  /// `work_items` share the scan; 0: as suits the device. Tests run the GPU's way on CPUs.
  explicit ScanStage(const Device& device, std::size_t work_items = 0);
  /// Exclusive prefix sum of data[0, n) in place; returns the 64-bit total when `wanted` (waits).
  std::uint64_t run(Buffer<std::uint32_t>& data, std::uint32_t n, bool wanted);

 private:
  std::size_t work_items_;
  Kernel<Buf<std::uint32_t>, std::uint32_t, Buf<std::uint64_t>> scan_;
  Buffer<std::uint64_t> total_;
};

class SortStage {
 public:
  /// Work-groups of one work-item sort 11 bits a pass, larger ones 4; 0: as suits the device.
  explicit SortStage(const Device& device, std::size_t work_items = 0);
  /// Sorts n pairs by the low `bits` of the key, stably. The scratch buffers are swapped in and out.
  void run(Buffer<std::uint32_t>& keys,
           Buffer<std::uint32_t>& values,
           Buffer<std::uint32_t>& key_scratch,
           Buffer<std::uint32_t>& value_scratch,
           std::uint32_t n,
           int bits,
           ScanStage& scan);

 private:
  std::size_t work_items_;
  int digit_bits_;
  std::size_t groups_;
  Buffer<std::uint32_t> histogram_;
  Kernel<Buf<const std::uint32_t>, std::uint32_t, std::uint32_t, std::uint32_t, Buf<std::uint32_t>> count_;
  Kernel<Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>>
      scatter_;
};

class BinStage {
 public:
  explicit BinStage(const Device& device);
  /// keys, footprints, tile_rows (RayBuffers) -> order, emission, tile, payload, first; fills visible and
  /// instances. N -> M -> K.
  /// Error{kDevice} with numbers when the frame needs more than max_instances.
  void run(const shared::FrameParams& frame,
           const Buffer<std::uint32_t>& tile_rows,
           FrameBuffers& buffers,
           SortStage& sort,
           ScanStage& scan,
           std::size_t max_instances);

 private:
  Device device_;
  Kernel<Buf<const std::uint32_t>, std::uint32_t, std::uint32_t, Buf<std::uint32_t>> visible_count_;
  Kernel<Buf<const std::uint32_t>,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>>
      visible_write_;
  Kernel<Buf<const std::uint32_t>,
         std::uint32_t,
         std::uint32_t,
         Buf<const shared::Footprint>,
         Buf<std::uint32_t>>
      instance_count_;
  Kernel<shared::FrameParams,
         Buf<const std::uint32_t>,
         std::uint32_t,
         std::uint32_t,
         Buf<const shared::Footprint>,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>>
      instance_emit_;
  Kernel<Buf<const std::uint32_t>, std::uint32_t, std::uint32_t, std::uint32_t, Buf<std::uint32_t>>
      tile_ranges_;
};

/// What a backward pass may give beside the gradients of particles.
struct BackwardExtras {
  bool errors = false;         // ray_error -> instance_error, weighted by blending
  bool ray_gradients = false;  // dL/d(direction), and with origins dL/d(origin), of every ray -> ray_grads
};

class RenderStage {
 public:
  RenderStage(const Device& device, const Variant& variant);
  void run(const shared::FrameParams& frame,
           const ParticleBuffers& particles,
           const RayBuffers& rays,
           FrameBuffers& buffers);  // K -> S
  /// out, grad_out -> grads. S -> K.
  void run_backward(const shared::FrameParams& frame,
                    const RayBuffers& rays,
                    FrameBuffers& buffers,
                    const BackwardExtras& extras);

 private:
  Device device_;
  Variant variant_;
  using Forward = Kernel<shared::FrameParams,
                         BufSensor,
                         BufRealConst,
                         BufRealConst,
                         Buf<const std::uint32_t>,
                         Buf<const std::uint32_t>,
                         BufRealConst,
                         BufRealConst,
                         Buf<const std::uint32_t>,
                         BufRealConst,
                         Buf<const std::uint32_t>,
                         BufActors,
                         BufReal>;
  Forward render_;  // of render.cl or render_per_ray.cl
  using Backward = Kernel<shared::FrameParams,
                          BufSensor,
                          BufRealConst,
                          BufRealConst,
                          Buf<const std::uint32_t>,
                          Buf<const std::uint32_t>,
                          BufRealConst,
                          BufRealConst,
                          Buf<const shared::Footprint>,
                          Buf<const std::uint32_t>,
                          BufRealConst,
                          BufRealConst,
                          BufReal,
                          BufRealConst,
                          BufReal,
                          BufReal>;
  Backward& backward(const BackwardExtras& extras);
  std::optional<Backward> backward_[2][2];  // [errors][ray_gradients], made when asked for
};

}  // namespace simuli
