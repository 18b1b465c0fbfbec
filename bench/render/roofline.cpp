#include "bench/render/roofline.hpp"

#include <bit>
#include <string_view>
#include <vector>

#include "host/device/render/device/sort.hpp"
#include "host/device/render/frame/variant.hpp"
#include "host/device/render/options/lane_shape.hpp"
#include "host/device/runtime/program.hpp"

namespace simuli::bench {
namespace {

// 12 chains hide the latency of a multiply-add on processors with up to 32 vector registers. F: 16 lanes on
// CPUs; one on GPUs, whose neighbouring work-items access neighbouring memory.
constexpr std::string_view kPeakText = R"(
#include "math/lanes.h"
__kernel void multiply_add(const uint rounds, const float factor, __global real* out) {
  F x[CHAINS];
#pragma unroll
  for (int k = 0; k < CHAINS; ++k) x[k] = (F)(k + 1) * 1e-3f;
  const F f = (F)factor, g = (F)(1.0f - factor);
  for (uint i = 0; i < rounds; ++i) {
#pragma unroll
    for (int k = 0; k < CHAINS; ++k) x[k] = fma(x[k], f, g);
  }
  F sum = x[0];
#pragma unroll
  for (int k = 1; k < CHAINS; ++k) sum += x[k];
  STV(out + get_global_id(0) * V, sum);
}
__kernel void triad(__global const real* b, __global const real* c, const float s, __global real* a) {
  const size_t i = get_global_id(0) * V;
  STV(a + i, fma(LDV(c + i), (F)s, LDV(b + i)));
}
)";
constexpr std::uint64_t kChains = 12, kReals = std::uint64_t{1} << 19U, kRounds = 512;
constexpr std::uint64_t kTriadReals = std::uint64_t{1} << 25U;  // 128 MB per array
constexpr double kLeast_s = 5e-3;  // minimum time of a launch: GPU clocks rise with the load
constexpr int kRuns = 7;

// Visits lists as kernels/render.cl does; of blending only the termination of rays remains.
constexpr std::string_view kVisitsText = R"(
#include "math/response.h"
#include "math/tile.h"
__kernel void count_visits(const FrameParams frame,
                           __global const SensorConstants* sensor,
                           __global const real* world_ray,
                           __global const real* ray_u,
                           __global const uint* first,
                           __global const uint* payload,
                           __global const real* records,
                           __global uint* visits) {
  const uint tile = get_group_id(0), lid = get_local_id(0), base = tile * SIM_TILE_RAYS;
  const real log_cut = log(sensor->alpha_cut);
  RayLanes ray[NR];
  F transmittance[NR];
  uint alive = 0, looked = 0, changed = 0;
  for (int j = 0; j < NR; ++j) {
    load_ray(world_ray, ray_u, frame.slots, base + SIM_VECTOR_SLOT(j, lid), &ray[j]);
    transmittance[j] = (F)R(1.0);
    alive |= (ANY(is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2])) ? 1u : 0u) << j;
  }
  for (uint i = first[tile]; i < first[tile + 1] && alive; ++i) {
    const uint packed = payload[i];
    real record[SIM_RECORD];
    for (int k = 0; k < SIM_RECORD; ++k) record[k] = records[(ulong)(packed & SIM_PARTICLE_MASK) * SIM_RECORD + k];
    const real box_mean = nearest_box_mean(record, ray_u[base]);
    uint vectors = vectors_of(packed, lid) & alive;
    SIM_EACH_VECTOR_OF(j, vectors) {
      ++looked;
      Response response;
      respond(record, box_mean, &ray[j], sensor->model.t_min, sensor->model.t_max, &response);
      if (!ANY(response.inside)) continue;
      ++changed;
      const F alpha = SEL(response.inside, VMIN(raw_alpha(record, response.q, log_cut), (F)SIM_ALPHA_MAX), (F)R(0.0));
      transmittance[j] -= alpha * transmittance[j];
      const I done = AND(transmittance[j] < sensor->transmittance_cut, response.inside);
      for (int k = 0; k < 3; ++k) ray[j].d[k] = SEL(done, (F)R(0.0), ray[j].d[k]);
      const I going = is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2]);
      if (!ANY(going)) alive &= ~(1u << j);
    }
  }
  visits[2 * get_global_id(0)] = looked;
  visits[2 * get_global_id(0) + 1] = changed;
}
)";

/// Returns the shortest time of `launch`'s kernel in s.
template <class F>
double best_seconds(const Device& device, const F& launch) {
  Profile& profile = device.profile();
  double best_ms = 0.0;
  for (int i = -1; i < kRuns; ++i) {  // the first launch compiles and touches the pages
    profile.reset();
    launch();
    const double ms = profile.rows().at(0).min_ms;
    if (i == 0 || (i > 0 && ms < best_ms)) best_ms = ms;
  }
  profile.reset();
  return best_ms * 1e-3;
}

double giga(std::uint64_t count) { return static_cast<double>(count) * 1e-9; }

// Operations: a fused multiply-add counts as two, a call of a built-in function as one. Counted with Oclgrind
// for 300, 1000 and 3000 particles and solved (bench/RESULTS.md, "Roofline").
struct Operations {
  std::uint64_t project;           // per visible particle, with its share of the culled particles
  std::uint64_t project_backward;  // per visible particle
  std::uint64_t blend_slot;        // background; for a LiDAR also its drop function
};
constexpr Operations kCameraOperations{1037, 880, 6}, kLidarOperations{1970, 879, 143};
constexpr std::uint64_t kRespond = 24, kRespondWithOrigins = 57;  // per visited lane
constexpr std::uint64_t kBlend = 31, kBlendBackward = 123;        // per lane of a vector that changes
constexpr std::uint64_t kSum = 20, kBackwardSlot = 9;             // per lane of a pair; per slot

}  // namespace

Peak measure_peak(const Device& device) {
  const auto lanes = static_cast<std::uint64_t>(lane_shape_of(device, Precision::kFloat).lanes);
  const Program program = Program::from_text(
      device, "bench/peak.cl", kPeakText, lane_options(device, Precision::kFloat).define("CHAINS", kChains));
  Peak peak;
  {
    Kernel kernel(program, "multiply_add");
    Buffer<float> out(device, "peak", kReals);
    double s = 0.0;
    for (std::uint64_t rounds = kRounds; s < kLeast_s; rounds *= 4) {
      s = best_seconds(device, [&] {
        kernel.run(kReals / lanes,
                   Range::none(),
                   {{"rounds", static_cast<std::uint32_t>(rounds)}, {"factor", 0.5F}, {"out", out}});
      });
      peak.gflop_s = giga(2 * kChains * kReals * rounds) / s;
    }
  }
  Kernel kernel(program, "triad");
  Buffer<float> a(device, "triad", kTriadReals), b(device, "triad", kTriadReals),
      c(device, "triad", kTriadReals);
  const double s = best_seconds(device, [&] {
    kernel.run(kTriadReals / lanes, Range::none(), {{"b", b}, {"c", c}, {"s", 0.5F}, {"a", a}});
  });
  peak.gbyte_s = giga(3 * kTriadReals * sizeof(float)) / s;
  return peak;
}

Visits count_visits(const Pass& pass) {
  const Device& device = pass.buffers().binned.device();
  const auto work_items = static_cast<std::size_t>(pass.variant().options.shape.work_items);
  Kernel kernel(Program::from_text(device, "bench/visits.cl", kVisitsText, pass.variant().build_options()),
                "count_visits");
  const FrameBuffers& buffers = pass.buffers();
  const std::size_t items = std::size_t{pass.frame().tiles_x} * pass.frame().tiles_y * work_items;
  Buffer<std::uint32_t> counted(device, "visits", 2 * items);
  const RayBuffers rays = pass.rays().buffers();
  kernel.run(items,
             work_items,
             {{"frame", pass.frame()},
              buffers.constants,
              buffers.rays,
              rays,
              buffers.binned,
              buffers.projected,
              {"visits", counted}});
  Visits visits;
  const std::vector<std::uint32_t> counts = counted.download();
  for (std::size_t i = 0; i < counts.size(); i += 2) {
    visits.looked += counts[i];
    visits.changed += counts[i + 1];
  }
  return visits;
}

std::map<std::string, StageWork> stage_work(const Pass& pass) {
  const Device& device = pass.buffers().binned.device();
  const FrameKind& kind = pass.variant().frame;
  const bool is_lidar = kind.sensor == SensorType::kLidar;
  const Operations& operations = is_lidar ? kLidarOperations : kCameraOperations;
  const std::uint64_t visible = pass.buffers().binned.visible, pairs = pass.buffers().binned.pairs;
  const std::uint64_t particles = pass.frame().particles, slots = pass.frame().slots,
                      tiles = std::uint64_t{pass.frame().tiles_x} * pass.frame().tiles_y;
  const std::uint64_t coefficients =
      3 * static_cast<std::uint64_t>((kind.sh_degree + 1) * (kind.sh_degree + 1));
  const std::uint64_t ray_rows = (kind.origins ? 6 : 3) + 1;  // and the position along x
  const std::uint64_t outputs = kind.median ? SIM_O_DROP : SIM_O_MEDIAN;
  const auto lanes = static_cast<std::uint64_t>(pass.variant().options.shape.lanes);
  const Visits visits = count_visits(pass);
  const std::uint64_t looked = lanes * visits.looked, changed = lanes * visits.changed;
  const std::uint64_t respond = kind.origins ? kRespondWithOrigins : kRespond;
  const auto tile_bits = static_cast<int>(std::bit_width(tiles - 1));

  constexpr std::uint64_t kReal = 4, kWord = 4, kFootprint = 16, kGradient = SIM_GRAD * kReal,
                          kRecord = SIM_RECORD * kReal;
  std::map<std::string, StageWork> work;
  work["project"] = {
      giga(operations.project * visible),
      giga(particles * (SIM_SH * kReal + kWord) + visible * (coefficients * kReal + kRecord + kFootprint))};
  work["bin"] = {0.0,
                 giga(2 * particles * kWord + visible * (2 * kWord + 2 * (kWord + kFootprint)) +
                      pairs * (2 * kWord + kWord) + tiles * kWord)};
  work["sort"] = {
      0.0,
      giga(5 * kWord *
           (visible * SortStage::passes(device, 32) + pairs * SortStage::passes(device, tile_bits)))};
  work["blend"] = {giga(looked * respond + changed * kBlend + slots * operations.blend_slot),
                   giga(slots * (ray_rows + outputs) * kReal + visible * kRecord + pairs * kWord)};
  work["blend_backward"] = {
      giga(looked * respond + changed * kBlendBackward + slots * kBackwardSlot +
           pairs * kSum * lanes * static_cast<std::uint64_t>(pass.variant().options.shape.work_items)),
      giga(slots * (ray_rows + outputs + 5) * kReal + visible * (kRecord + kFootprint + kWord) +
           pairs * (kWord + kGradient))};
  work["project_backward"] = {
      giga(operations.project_backward * visible),
      giga(visible * ((SIM_SH + coefficients) * kReal + kFootprint + 3 * kReal) + pairs * kGradient +
           particles * ((SIM_SH + coefficients) * kReal + 2 * kWord))};
  return work;
}

}  // namespace simuli::bench
