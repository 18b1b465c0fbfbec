#include "bench/render/stages.hpp"

#include <fmt/format.h>
#include <map>
#include <optional>

#include "bench/particles/particle_street.hpp"
#include "bench/render/roofline.hpp"
#include "bench/render/scene.hpp"
#include "host/device/render/scene/renderer.hpp"

namespace simuli::bench {
namespace {

/// Stage of the table by kernel.
const std::map<std::string, std::string>& stage_of_kernel() {
  static const std::map<std::string, std::string> kStages{
      {"rays", "rays"},
      {"cull_clusters", "project"},
      {"project", "project"},
      {"radix_count", "sort"},
      {"radix_scatter", "sort"},
      {"scan_exclusive", "sort"},
      {"visible_count", "bin"},
      {"visible_write", "bin"},
      {"pair_count", "bin"},
      {"pair_emit", "bin"},
      {"tile_ranges", "bin"},
      {"render", "blend"},
      {"render_window", "blend"},
      {"render_per_ray", "blend"},
      {"render_bwd", "blend_backward"},
      {"project_bwd", "project_backward"},
  };
  return kStages;
}

struct Sample {
  double frame_ms = 0.0;
  std::map<std::string, double> stage_ms;
};

class Case {
 public:
  Case(const Device& device,
       SetKind kind,
       const StagesOptions& options,
       const RenderOptions& render,
       StreetOrder order = StreetOrder::kCoherent)
      : options_(render),
        renderer_(device, options_),
        particles_(device,
                   street_particles(kind, options.sh_degree, options.particles, options.seed, order),
                   options_),
        rays_(bench_rays(device, kind, options_)),
        param_grads_(device, "parameter gradients", Precision::kFloat) {
    const Pose pose = world_from_bench_sensor(kind);
    view_ = {pose, pose, {0.0F, 0.0F, 0.0F}};
  }

  /// Returns the share of tile pairs that no ray of their tile intersects, in %: the possible saving of a
  /// finer tile test. Valid only if no ray terminates before its last particle.
  double pairs_without_ray() {
    pass_ = renderer_.render(particles_, rays_, view_);
    pass_->set_output_gradients(std::vector<double>(5 * rays(), 1.0));
    pass_->backward(particles_, param_grads_);
    // The gradient of a feature is the sum of its weights.
    const std::vector<float> grads = pass_->gradients().grads.download_float();
    const std::size_t pairs = pass_->buffers().binned.pairs;
    std::size_t without = 0;
    for (std::size_t i = 0; i < pairs; ++i)
      without += grads[i * SIM_GRAD + SIM_G_FEATURE] == 0.0F ? 1 : 0;
    return 100.0 * static_cast<double>(without) / static_cast<double>(pairs);
  }

  /// Renders one frame, with gradients if `backward`.
  Sample run(bool backward) {
    Profile& profile = renderer_.device().profile();
    profile.reset();
    Sample sample;
    sample.frame_ms = time_ms([&] {
      pass_ = renderer_.render(particles_, rays_, view_);
      renderer_.device().finish();
    });
    if (backward) {
      if (gradients_.empty()) gradients_.assign(5 * rays(), 1e-3);
      pass_->set_output_gradients(gradients_);
      pass_->backward(particles_, param_grads_);
      renderer_.device().finish();
    }
    sample.stage_ms = stage_times(profile);
    return sample;
  }

  /// Returns the last frame.
  [[nodiscard]] const Pass& pass() const { return *pass_; }
  [[nodiscard]] std::size_t rays() const { return rays_.grid().rays; }

 private:
  RenderOptions options_ = paper_options();
  Renderer renderer_;
  std::optional<Pass> pass_;
  ParticleBuffers particles_;
  SensorRays rays_;
  RealBuffer param_grads_;
  std::vector<double> gradients_;
  View view_;
};

/// Adds the work of a stage and its share of each peak.
void add_roofline(const std::string& name,
                  const StageWork& work,
                  const Spread& time_ms,
                  const Peak& peak,
                  std::vector<Row>& rows) {
  const auto add = [&](const char* what, const char* unit, double done, double peak_per_s) {
    const double share = 100.0 * done / (peak_per_s * time_ms.median * 1e-3);
    rows.push_back({name + "/" + what, 1e3 * done, unit, 0.0});
    rows.push_back({name + "/" + what + "_of_peak", share, "%", share * time_ms.half_iqr / time_ms.median});
  };
  if (work.gflop > 0.0) add("arithmetic", "MFLOP", work.gflop, peak.gflop_s);
  add("traffic", "MB", work.gbyte, peak.gbyte_s);
}

}  // namespace

std::map<std::string, double> stage_times(Profile& profile) {
  std::map<std::string, double> times;
  for (const ProfileRow& row : profile.rows()) {
    const auto stage = stage_of_kernel().find(row.kernel);
    if (stage != stage_of_kernel().end()) times[stage->second] += row.total_ms;
  }
  return times;
}

std::vector<Row> run_stages(const std::string& device_request,
                            const StagesOptions& options,
                            const std::function<void(const std::string&)>& note) {
  DeviceOptions device_options;
  device_options.profiling = true;
  const Device device = Device::best(device_request, device_options);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const Peak peak = measure_peak(device);
  std::vector<Row> rows{{"stages/peak/fma", peak.gflop_s, "GFLOP/s", 0.0},
                        {"stages/peak/bandwidth", peak.gbyte_s, "GB/s", 0.0}};
  for (const SetKind kind : {SetKind::kCamera, SetKind::kLidar}) {
    const std::string base = fmt::format("stages/{}_{}k",
                                         kind == SetKind::kCamera ? "camera_640x360" : "lidar_64x2650",
                                         options.particles / 1000);
    RenderOptions one_ray_per_item = paper_options(), no_ray_done = one_ray_per_item;
    one_ray_per_item.shape = LaneShape{1, 1, 256};
    no_ray_done.transmittance_cut = 0.0;
    Case shaped(device, kind, options, {}), one_ray(device, kind, options, one_ray_per_item);
    Case shuffled(device, kind, options, {}, StreetOrder::kShuffled);
    std::map<std::string, std::vector<double>> samples;
    std::vector<double> ratios, order_ratios;
    for (int i = -2; i < options.frames; ++i) {
      const Sample a = shaped.run(true);
      const Sample b = one_ray.run(false);
      const Sample c = shuffled.run(false);
      if (i < 0) continue;  // the first launches compile
      samples["frame"].push_back(a.frame_ms);
      for (const auto& [stage, ms] : a.stage_ms) samples[stage].push_back(ms);
      samples["blend_one_ray_per_item"].push_back(b.stage_ms.at("blend"));
      ratios.push_back(b.stage_ms.at("blend") / a.stage_ms.at("blend"));
      samples["frame_shuffled"].push_back(c.frame_ms);
      order_ratios.push_back(a.frame_ms / c.frame_ms);
    }
    const auto& buffers = shaped.pass().buffers();
    note(fmt::format("{}: {} visible of {} particles, {} tile instances, {} rays",
                     base,
                     buffers.binned.visible,
                     options.particles,
                     buffers.binned.pairs,
                     shaped.rays()));
    for (const char* stage : {"rays",
                              "project",
                              "sort",
                              "bin",
                              "blend",
                              "frame",
                              "frame_shuffled",
                              "blend_backward",
                              "project_backward",
                              "blend_one_ray_per_item"}) {
      const Spread s = spread_of(samples.at(stage));
      rows.push_back({base + "/" + stage, s.median, "ms", s.half_iqr});
    }
    for (const auto& [stage, work] : stage_work(shaped.pass())) {
      add_roofline(base + "/" + stage, work, spread_of(samples.at(stage)), peak, rows);
    }
    const Spread ratio = spread_of(ratios);
    rows.push_back({base + "/blend_speedup", ratio.median, "x", ratio.half_iqr});
    const Spread order_ratio = spread_of(order_ratios);
    rows.push_back({base + "/frame_of_shuffled", order_ratio.median, "x", order_ratio.half_iqr});
    const Spread frame = spread_of(samples.at("frame"));
    const double mega = static_cast<double>(shaped.rays()) * 1e-3;
    rows.push_back({base + "/rate",
                    mega / frame.median,
                    kind == SetKind::kCamera ? "MP/s" : "MR/s",
                    mega * frame.half_iqr / (frame.median * frame.median)});
    // Inputs of the model of other devices (bench/gpu/model.py).
    for (const auto& [what, count] : {std::pair{"visible", std::size_t{buffers.binned.visible}},
                                      {"instances", std::size_t{buffers.binned.pairs}},
                                      {"rays_in_tiles", std::size_t{shaped.pass().frame().slots}}}) {
      rows.push_back({base + "/" + what, static_cast<double>(count), "1", 0.0});
    }
    const double without = Case(device, kind, options, no_ray_done).pairs_without_ray();
    rows.push_back({base + "/instances_without_ray", without, "%", 0.0});
  }
  return rows;
}

}  // namespace simuli::bench
