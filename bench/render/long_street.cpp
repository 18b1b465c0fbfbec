#include "bench/render/long_street.hpp"

#include <ctime>
#include <fmt/format.h>

#include "bench/render/scene.hpp"
#include "bench/render/stages.hpp"
#include "host/render/options/quality.hpp"
#include "host/scene/particle_street.hpp"

namespace simuli::bench {
namespace {

constexpr double kShort_m = 180.0;

/// A street on the device, once as particles that stay as they are and once as some that may change.
struct Street {
  Street(const Device& device, SetKind of, const LongStreetOptions& options, double length)
      : Street(device,
               of,
               length,
               street_particles(
                   of,
                   3,
                   static_cast<Eigen::Index>(static_cast<double>(options.particles) * length / kShort_m),
                   1,
                   StreetOrder::kCoherent,
                   length)) {}
  Street(const Device& device, SetKind of, double length, const GaussianSet& set)
      : kind(of),
        length_m(length),
        clustered(device, set, RenderOptions{}),
        all(device, set, Precision::kFloat) {}

  SetKind kind;
  double length_m;
  ParticleBuffers clustered, all;
};

class Place {
 public:
  Place(Renderer& renderer, const SensorRays& rays, const Street& street, double share)
      : renderer_(renderer), rays_(rays), street_(street), x_m_((share - 0.5) * street.length_m) {
    Pose pose = world_from_bench_sensor(street.kind);
    pose.translation.x() = x_m_;
    view_ = {pose, pose};
  }

  void add_rows(int frames, std::vector<Row>& rows) {
    std::map<std::string, std::vector<double>> samples;
    for (int i = -2; i < frames; ++i) {
      const auto with = times(street_.clustered), without = times(street_.all);
      if (i < 0) continue;  // the first launches compile
      for (const char* what : {"frame", "project", "bin", "processor"}) {
        samples[what].push_back(with.at(what));
        samples[std::string(what) + "_of_all"].push_back(with.at(what) / without.at(what));
      }
    }
    const std::string base = fmt::format("long_street/{}/{:.0f}m_at_{:+.0f}",
                                         street_.kind == SetKind::kCamera ? "camera" : "lidar",
                                         street_.length_m,
                                         x_m_);
    for (const auto& [what, values] : samples) {
      const Spread s = spread_of(values);
      rows.push_back({base + "/" + what, s.median, what.ends_with("_of_all") ? "x" : "ms", s.half_iqr});
    }
    const Pass pass = renderer_.render(street_.clustered, rays_, view_);
    const std::vector<std::uint32_t> live = pass.buffers().projected.live.download();
    const std::size_t clusters = (street_.clustered.count + SIM_CLUSTER - 1) / SIM_CLUSTER;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < clusters; ++i) kept += live[i];
    rows.push_back(
        {base + "/live", 100.0 * static_cast<double>(kept) / static_cast<double>(clusters), "%", 0.0});
    rows.push_back({base + "/visible", static_cast<double>(pass.buffers().binned.visible), "1", 0.0});
  }

 private:
  /// ms of a frame, and of its stages.
  std::map<std::string, double> times(const ParticleBuffers& particles) {
    Profile& profile = renderer_.device().profile();
    profile.reset();
    const std::clock_t start = std::clock();
    const double frame_ms = time_ms([&] {
      const Pass pass = renderer_.render(particles, rays_, view_);
      renderer_.device().finish();
    });
    auto all = stage_times(profile);
    all["frame"] = frame_ms;
    all["processor"] = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return all;
  }

  Renderer& renderer_;
  const SensorRays& rays_;
  const Street& street_;
  double x_m_;
  View view_;
};

}  // namespace

std::vector<Row> run_long_street(const std::string& device_request,
                                 const LongStreetOptions& options,
                                 const Progress& note) {
  const Device device = profiled_device(device_request, note);
  std::vector<Row> rows;
  Renderer renderer(device, {});
  for (const SetKind kind : {SetKind::kCamera, SetKind::kLidar}) {
    const SensorRays rays = bench_rays(device, kind, renderer.options());
    const Street usual(device, kind, options, kShort_m);
    Place(renderer, rays, usual, 0.5).add_rows(options.frames, rows);
    const Street street(device, kind, options, options.length_m);
    for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      Place(renderer, rays, street, share).add_rows(options.frames, rows);
    }
  }
  return rows;
}

}  // namespace simuli::bench
