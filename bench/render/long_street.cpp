#include "bench/render/long_street.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fmt/format.h>

#include "bench/particles/particle_street.hpp"
#include "bench/render/scene.hpp"
#include "bench/render/stages.hpp"
#include "host/device/render/options/quality.hpp"
#include "host/device/render/pages/particle_pages.hpp"

namespace simuli::bench {
namespace {

constexpr double kShort_m = 180.0;

RenderOptions with_detail(double detail) {
  RenderOptions options;
  options.detail = detail;
  return options;
}

GaussianSet long_set(SetKind kind, const LongStreetOptions& options, double length_m) {
  return street_particles(
      kind,
      3,
      static_cast<Eigen::Index>(static_cast<double>(options.particles) * length_m / kShort_m),
      1,
      StreetOrder::kCoherent,
      length_m);
}

/// A street on the device, once as a constant set and once with levels of detail.
struct Street {
  Street(const Device& device, SetKind of, const LongStreetOptions& options, double length)
      : Street(device, of, options, length, long_set(of, options, length)) {}
  Street(const Device& device,
         SetKind of,
         const LongStreetOptions& options,
         double length,
         const GaussianSet& set)
      : kind(of),
        length_m(length),
        clustered(device, set, RenderOptions{}),
        all(device, set, Precision::kFloat),
        levels(device, set, with_detail(options.detail)) {}

  SetKind kind;
  double length_m;
  ParticleBuffers clustered, all, levels;
};

struct Renderers {
  Renderer usual, detail;
};

/// Renders frames one metre apart, as from a car at 10 m/s, with all particles of a street on the device, and
/// with only the pages that frames may need. Cameras use levels of detail, since they see to the end of the
/// street.
class LongDrive {
 public:
  LongDrive(const Device& device, SetKind kind, const LongStreetOptions& options, const GaussianSet& set)
      : device_(device),
        kind_(kind),
        options_(with_detail(kind == SetKind::kCamera ? options.detail : 0.0)),
        set_(std::make_shared<const GaussianSet>(set)),
        length_m_(options.length_m) {}

  void add_rows(std::vector<Row>& rows) const {
    const std::string base =
        fmt::format("long_street/{}/drive/", kind_ == SetKind::kCamera ? "camera" : "lidar");
    const auto add = [&](const std::string& name, double value, const char* unit) {
      rows.push_back({base + name, value, unit, 0.0});
    };
    const ParticlePages known(device_, set_, options_, 1);
    add("pages", known.pages(), "1");
    std::uint32_t most = 0;
    {
      // With all pages resident: the maximum number of pages per frame.
      ParticlePages pages(device_, set_, options_, known.pages());
      drive(pages, [&] { most = std::max(most, pages.seen()); });
    }
    const std::uint32_t places = most + most / 10;
    add("places", places, "1");
    {
      ParticlePages pages(device_, set_, options_, places);
      double brought = 0.0, at_once = 0.0;
      const Times times = drive(pages, [&] {
        brought += pages.brought();
        at_once = std::max<double>(at_once, pages.brought());
      });
      add("brought_a_metre", brought / static_cast<double>(times.frame.size()), "1");
      add("brought_at_once", at_once, "1");
      add_times("", times, add);
    }
    {
      const ParticleBuffers all(device_, *set_, options_);
      add_times("all_", drive(all, [] {}), add);
    }
  }

 private:
  struct Times {
    std::vector<double> frame, processor;  // ms, ascending
    double device_mb = 0.0;
  };
  template <class Add>
  static void add_times(const std::string& name, const Times& times, const Add& add) {
    const auto at = [](const std::vector<double>& of, std::size_t percent) {
      return of[(of.size() - 1) * percent / 100];
    };
    add(name + "frame_median", at(times.frame, 50), "ms");
    add(name + "frame_p99", at(times.frame, 99), "ms");
    add(name + "processor_median", at(times.processor, 50), "ms");
    add(name + "processor_p99", at(times.processor, 99), "ms");
    add(name + "device", times.device_mb, "MB");
  }
  /// Drives along the middle half of the street; the pages of the first frames are not counted.
  template <class Particles, class AfterFrame>
  Times drive(Particles& particles, const AfterFrame& after) const {
    Renderer renderer(device_, options_);
    const SensorRays rays = bench_rays(device_, kind_, renderer.options());
    Times times;
    for (int metre = -3; metre < static_cast<int>(length_m_ / 2); ++metre) {
      Pose pose = world_from_bench_sensor(kind_);
      pose.translation.x() = -length_m_ / 4 + std::max(metre, 0);
      const std::clock_t start = std::clock();
      const double frame_ms = time_ms([&] {
        const Pass pass = renderer.render(particles, rays, {pose, pose});
        renderer.device().finish();
      });
      if (metre < 0) continue;
      times.frame.push_back(frame_ms);
      times.processor.push_back(1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
      after();
    }
    // Memory of this set and of all buffers of frames.
    times.device_mb = static_cast<double>(device_.memory().now) / 1e6;
    std::sort(times.frame.begin(), times.frame.end());
    std::sort(times.processor.begin(), times.processor.end());
    return times;
  }

  Device device_;
  SetKind kind_;
  RenderOptions options_;
  std::shared_ptr<const GaussianSet> set_;
  double length_m_;
};

class StreetPosition {
 public:
  StreetPosition(Renderers& renderers,
                 const SensorRays& rays,
                 const SensorRays& detail_rays,
                 const Street& street,
                 double share)
      : renderers_(renderers),
        rays_(rays),
        detail_rays_(detail_rays),
        street_(street),
        x_m_((share - 0.5) * street.length_m) {
    Pose pose = world_from_bench_sensor(street.kind);
    pose.translation.x() = x_m_;
    view_ = {pose, pose};
  }

  void add_rows(int frames, std::vector<Row>& rows) {
    std::map<std::string, std::vector<double>> samples;
    for (int i = -2; i < frames; ++i) {
      const auto with = times(renderers_.usual, rays_, street_.clustered),
                 without = times(renderers_.usual, rays_, street_.all),
                 levels = times(renderers_.detail, detail_rays_, street_.levels);
      if (i < 0) continue;  // the first launches compile
      for (const char* what : {"frame", "project", "bin", "processor"}) {
        samples[what].push_back(with.at(what));
        samples[std::string(what) + "_of_all"].push_back(with.at(what) / without.at(what));
        samples[std::string(what) + "_detail"].push_back(levels.at(what) / with.at(what));
      }
    }
    const std::string base = fmt::format("long_street/{}/{:.0f}m_at_{:+.0f}",
                                         street_.kind == SetKind::kCamera ? "camera" : "lidar",
                                         street_.length_m,
                                         x_m_);
    for (const auto& [what, values] : samples) {
      const Spread s = spread_of(values);
      rows.push_back({base + "/" + what,
                      s.median,
                      what.ends_with("_of_all") || what.ends_with("_detail") ? "x" : "ms",
                      s.half_iqr});
    }
    const Pass levels = renderers_.detail.render(street_.levels, detail_rays_, view_);
    rows.push_back(
        {base + "/visible_detail", static_cast<double>(levels.buffers().binned.visible), "1", 0.0});
    const RayResults reduced = levels.results();
    const Pass pass = renderers_.usual.render(street_.clustered, rays_, view_);
    add_errors(base, pass.results(), reduced, rows);
    const std::vector<std::uint32_t> live = pass.buffers().projected.live.download();
    const std::size_t clusters = (street_.clustered.count + SIM_CLUSTER - 1) / SIM_CLUSTER;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < clusters; ++i) kept += live[i];
    rows.push_back(
        {base + "/live", 100.0 * static_cast<double>(kept) / static_cast<double>(clusters), "%", 0.0});
    rows.push_back({base + "/visible", static_cast<double>(pass.buffers().binned.visible), "1", 0.0});
  }

 private:
  /// Returns the ms of a frame and of its stages.
  std::map<std::string, double> times(Renderer& renderer,
                                      const SensorRays& rays,
                                      const ParticleBuffers& particles) {
    Profile& profile = renderer.device().profile();
    profile.reset();
    const std::clock_t start = std::clock();
    const double frame_ms = time_ms([&] {
      const Pass pass = renderer.render(particles, rays, view_);
      renderer.device().finish();
    });
    auto all = stage_times(profile);
    all["frame"] = frame_ms;
    all["processor"] = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return all;
  }

  void add_errors(const std::string& base,
                  const RayResults& all,
                  const RayResults& reduced,
                  std::vector<Row>& rows) {
    double squares = 0.0;
    std::vector<double> off;
    for (std::size_t ray = 0; ray < all.rays; ++ray) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double error = std::clamp(static_cast<double>(all.feature[k][ray]), 0.0, 1.0) -
                             std::clamp(static_cast<double>(reduced.feature[k][ray]), 0.0, 1.0);
        squares += error * error;
      }
      if (all.transmittance[ray] < 0.5F && reduced.transmittance[ray] < 0.5F) {
        off.push_back(
            std::abs(static_cast<double>(all.expected_distance(ray) - reduced.expected_distance(ray))));
      }
    }
    rows.push_back({base + "/psnr_detail",
                    -10.0 * std::log10(squares / (3.0 * static_cast<double>(all.rays))),
                    "dB",
                    0.0});
    if (off.empty()) return;
    const auto p99 = off.begin() + static_cast<std::ptrdiff_t>(off.size() * 99 / 100);
    std::nth_element(off.begin(), p99, off.end());
    rows.push_back({base + "/p99_detail", 1e3 * *p99, "mm", 0.0});
  }

  Renderers& renderers_;
  const SensorRays& rays_;
  const SensorRays& detail_rays_;
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
  Renderers renderers{Renderer(device, {}), Renderer(device, with_detail(options.detail))};
  for (const SetKind kind : {SetKind::kCamera, SetKind::kLidar}) {
    LongDrive(device, kind, options, long_set(kind, options, options.length_m)).add_rows(rows);
  }
  for (const SetKind kind : {SetKind::kCamera, SetKind::kLidar}) {
    const SensorRays rays = bench_rays(device, kind, renderers.usual.options());
    const SensorRays detail_rays = bench_rays(device, kind, renderers.detail.options());
    const Street usual(device, kind, options, kShort_m);
    StreetPosition(renderers, rays, detail_rays, usual, 0.5).add_rows(options.frames, rows);
    const Street street(device, kind, options, options.length_m);
    for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      StreetPosition(renderers, rays, detail_rays, street, share).add_rows(options.frames, rows);
    }
  }
  return rows;
}

}  // namespace simuli::bench
