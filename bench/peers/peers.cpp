#include "bench/peers/peers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "bench/particles/particle_street.hpp"
#include "bench/peers/embree_tracer.hpp"
#include "bench/render/lidar_frames.hpp"
#include "bench/render/scene.hpp"
#include "bench/render/stages.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "host/device/render/rays/ray_grid.hpp"
#include "host/device/render/scene/sensor_in_frame.hpp"

namespace simuli::bench {
namespace {

constexpr int kShDegree = 3;
constexpr std::uint64_t kSeed = 1;
constexpr std::size_t kBlock = 8;  // packets along x and y that are traced consecutively

struct PacketShape {
  std::size_t columns, rows;
};

/// Rays of a sensor in the tracer's format.
struct PacketRays {
  TracedRays rays;
  std::vector<std::int32_t> ray_of_lane;  // -1: none
};

/// Groups rays into packets of neighbours: 4 x 4 pixels for a camera, 8 columns of 2 beams for a LiDAR, whose
/// beams are farther apart than columns.
PacketRays packets_of(const RayGrid& grid) {
  const std::size_t rows = grid.frame.rows;
  const std::size_t columns = grid.rays / rows;
  const PacketShape shape = grid.type == SensorType::kCamera ? PacketShape{4, 4} : PacketShape{8, 2};
  std::vector<std::size_t> slot_of_ray(grid.rays, grid.ray_of_slot.size());
  for (std::size_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
    if (grid.ray_of_slot[slot] >= 0) slot_of_ray[static_cast<std::size_t>(grid.ray_of_slot[slot])] = slot;
  }
  const std::size_t block_x = kBlock * shape.columns, block_y = kBlock * shape.rows;
  PacketRays out;
  for (std::size_t y0 = 0; y0 < rows; y0 += block_y) {
    for (std::size_t x0 = 0; x0 < columns; x0 += block_x) {
      for (std::size_t y1 = y0; y1 < std::min(y0 + block_y, rows); y1 += shape.rows) {
        for (std::size_t x1 = x0; x1 < std::min(x0 + block_x, columns); x1 += shape.columns) {
          for (std::size_t lane = 0; lane < shape.rows * shape.columns; ++lane) {
            const std::size_t x = x1 + lane % shape.columns, y = y1 + lane / shape.columns;
            const bool inside = x < columns && y < rows;
            out.ray_of_lane.push_back(inside ? static_cast<std::int32_t>(y * columns + x) : -1);
          }
        }
      }
    }
  }
  const std::size_t lanes = out.ray_of_lane.size(), slots = grid.ray_of_slot.size();
  const auto put = [&](std::vector<float>& to, std::size_t row) {
    to.assign(lanes, 0.0F);
    for (std::size_t i = 0; i < lanes; ++i) {
      if (out.ray_of_lane[i] < 0) continue;
      const std::size_t slot = slot_of_ray[static_cast<std::size_t>(out.ray_of_lane[i])];
      if (slot < slots) to[i] = grid.sensor_ray[row * slots + slot];
    }
  };
  for (std::size_t k = 0; k < 3; ++k) put(out.rays.direction[k], k);
  if (grid.lever_arms) {
    for (std::size_t k = 0; k < 3; ++k) put(out.rays.origin[k], 3 + k);
  }
  put(out.rays.time, 6);
  return out;
}

RayResults in_ray_order(const PacketRays& packets, const TracedResults& traced, std::size_t rays) {
  RayResults results;
  results.rays = rays;
  const std::array<std::pair<std::vector<float>*, const std::vector<float>*>, 6> pairs{
      {{&results.feature[0], &traced.feature[0]},
       {&results.feature[1], &traced.feature[1]},
       {&results.feature[2], &traced.feature[2]},
       {&results.transmittance, &traced.transmittance},
       {&results.distance, &traced.distance},
       {&results.median, &traced.median}}};
  for (const auto& [to, from] : pairs) {
    to->assign(rays, 0.0F);
    for (std::size_t i = 0; i < packets.ray_of_lane.size(); ++i) {
      const std::int32_t ray = packets.ray_of_lane[i];
      if (ray >= 0) (*to)[static_cast<std::size_t>(ray)] = (*from)[i];
    }
  }
  return results;
}

/// A set with its tracer for a sensor.
class Traced {
 public:
  Traced(const GaussianSet& set, const SensorRays& rays, const View& view, const RenderOptions& options)
      : tracer_({std::span(set.params.data(), static_cast<std::size_t>(set.params.size())),
                 static_cast<std::size_t>(set.size()),
                 set.sh_degree,
                 set.kind == SetKind::kCamera ? 3 : 1}),
        packets_(packets_of(rays.grid())),
        rays_(rays.grid().rays) {
    const SensorInFrame of_frame = sensor_in_frame(
        rays, view.scene_from_sensor_start, view.scene_from_sensor_end, options, view.background, view.drop);
    frame_ = {of_frame.constants, of_frame.moving};
  }
  void build() { tracer_.build(frame_); }
  void prepare() { tracer_.prepare(frame_); }
  void trace() { tracer_.trace(frame_, packets_.rays, results_); }
  [[nodiscard]] RayResults results() const { return in_ray_order(packets_, results_, rays_); }

 private:
  TracedFrame frame_;
  EmbreeTracer tracer_;
  PacketRays packets_;
  std::size_t rays_;
  TracedResults results_;
};

class Ours {
 public:
  Ours(const Device& device,
       const ParticleBuffers& particles,
       SetKind kind,
       const View& view,
       const RenderOptions& options)
      : particles_(particles),
        renderer_(device, options),
        rays_(bench_rays(device, kind, options)),
        view_(view) {}
  /// Times one frame from the call to the result on the device.
  double frame_ms() {
    renderer_.device().profile().reset();
    return time_ms([&] {
      pass_ = renderer_.render(particles_, rays_, view_);
      renderer_.device().finish();
    });
  }
  /// Returns the blending time of the last frame.
  double blend_ms() { return stage_times(renderer_.device().profile()).at("blend"); }
  [[nodiscard]] RayResults results() const { return pass_->results(); }
  [[nodiscard]] const SensorRays& rays() const { return rays_; }

 private:
  const ParticleBuffers& particles_;
  Renderer renderer_;
  std::optional<Pass> pass_;
  SensorRays rays_;
  View view_;
};

double mean_of(const std::vector<double>& values) {
  return values.empty()
             ? 0.0
             : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double middle_of(const std::vector<double>& sorted) {
  return sorted.empty() ? 0.0 : sorted[sorted.size() / 2];
}

PeerCase compare(const Device& device, SetKind kind, std::int64_t count, int frames) {
  const bool is_camera = kind == SetKind::kCamera;
  const GaussianSet set = street_particles(kind, kShDegree, count, kSeed);
  const ParticleBuffers particles(device, set, Precision::kFloat);
  const Pose pose = world_from_bench_sensor(kind);
  const View view{pose, pose, {0.0F, 0.0F, 0.0F}};
  RenderOptions alike_options;
  alike_options.extent = Extent::kExact;
  alike_options.order = Order::kPerRay;
  Ours ours(device, particles, kind, view, {}), alike(device, particles, kind, view, alike_options);
  Traced traced(set, alike.rays(), view, alike_options);
  PeerCase out;
  out.sensor = is_camera ? "camera_640x360" : "lidar_64x2650";
  out.particles = count;
  out.kind = kind;
  out.build_ms = time_ms([&] { traced.build(); });
  std::vector<double> ours_ms, blend_ms, alike_ms, prepare_ms, trace_ms, ratios, blend_ratios, alike_ratios;
  for (int i = -1; i < frames; ++i) {
    const double a = ours.frame_ms(), blended = ours.blend_ms();
    const double prepared = time_ms([&] { traced.prepare(); });
    const double shot = time_ms([&] { traced.trace(); });
    const double b = alike.frame_ms();
    if (i < 0) continue;  // the first launches compile
    ours_ms.push_back(a);
    blend_ms.push_back(blended);
    alike_ms.push_back(b);
    prepare_ms.push_back(prepared);
    trace_ms.push_back(shot);
    ratios.push_back((prepared + shot) / a);
    blend_ratios.push_back(shot / blended);
    alike_ratios.push_back((prepared + shot) / b);
  }
  out.ours_ms = spread_of(ours_ms);
  out.blend_ms = spread_of(blend_ms);
  out.alike_ms = spread_of(alike_ms);
  out.prepare_ms = spread_of(prepare_ms);
  out.trace_ms = spread_of(trace_ms);
  out.ratio = spread_of(ratios);
  out.blend_ratio = spread_of(blend_ratios);
  out.alike_ratio = spread_of(alike_ratios);
  const RayResults truth = traced.results(), by_default = ours.results(), by_ray = alike.results();
  if (is_camera) {
    out.ours_psnr_db = picture_psnr_db(by_default, truth);
    out.alike_psnr_db = picture_psnr_db(by_ray, truth);
  } else {
    const std::vector<double> d = distance_differences(by_default, truth);
    const std::vector<double> e = distance_differences(by_ray, truth);
    out.ours_median_m = middle_of(d);
    out.ours_mean_m = mean_of(d);
    out.alike_median_m = middle_of(e);
    out.alike_mean_m = mean_of(e);
  }
  return out;
}

}  // namespace

std::vector<PeerCase> run_peers(const std::string& device_request,
                                const PeersOptions& options,
                                const std::function<void(const std::string&)>& note) {
  const Device device = profiled_device(device_request, note);
  std::vector<PeerCase> cases;
  for (const SetKind kind : {SetKind::kCamera, SetKind::kLidar}) {
    for (const std::int64_t count : options.particles) {
      cases.push_back(compare(device, kind, count, options.frames));
      const PeerCase& c = cases.back();
      note(fmt::format("{} {} k: {:.1f} ms, Embree {:.1f} + {:.1f} ms, BVH built in {:.0f} ms",
                       c.sensor,
                       count / 1000,
                       c.ours_ms.median,
                       c.prepare_ms.median,
                       c.trace_ms.median,
                       c.build_ms));
    }
  }
  return cases;
}

RayResults traced_results(const GaussianSet& set,
                          const SensorRays& rays,
                          const View& view,
                          const RenderOptions& options) {
  Traced traced(set, rays, view, options);
  traced.build();
  traced.prepare();
  traced.trace();
  return traced.results();
}

}  // namespace simuli::bench
