#include "bench/paper/training.hpp"

#include <fmt/format.h>
#include <map>

#include "bench/particles/particle_street.hpp"
#include "io/synth/street.hpp"
#include "optim/train/memory.hpp"
#include "optim/train/paper/anchor_stage.hpp"
#include "optim/train/trainer.hpp"

namespace simuli::bench {
namespace {

/// Returns the stage of the table of a kernel; "other" for all others.
std::string stage_of(const std::string& kernel) {
  static const std::map<std::string, std::string> kStages{{"rays", "rays"},
                                                          {"project", "project"},
                                                          {"cull_clusters", "project"},
                                                          {"radix_count", "sort_and_bin"},
                                                          {"radix_scatter", "sort_and_bin"},
                                                          {"scan_exclusive", "sort_and_bin"},
                                                          {"visible_count", "sort_and_bin"},
                                                          {"visible_write", "sort_and_bin"},
                                                          {"pair_count", "sort_and_bin"},
                                                          {"pair_emit", "sort_and_bin"},
                                                          {"tile_ranges", "sort_and_bin"},
                                                          {"render", "blend"},
                                                          {"render_bwd", "blend_backward"},
                                                          {"project_bwd", "project_backward"},
                                                          {"adam", "adam"},
                                                          {"anchor_loss", "anchor"},
                                                          {"pixel_error", "errors_and_noise"},
                                                          {"beam_error", "errors_and_noise"},
                                                          {"accumulate_error", "errors_and_noise"},
                                                          {"jitter_means", "errors_and_noise"}};
  if (const auto found = kStages.find(kernel); found != kStages.end()) return found->second;
  return kernel.starts_with("loss") ? "loss" : "other";
}

Scene bench_scene(std::int64_t particles) {
  Scene scene;
  scene.camera = street_particles(SetKind::kCamera, 2, particles, 1);
  scene.lidar = street_particles(SetKind::kLidar, 1, particles, 2);
  // One in twenty is dead, for relocation.
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    for (Eigen::Index i = 0; i < set->size(); i += 20) set->opacity_logit()(i) = -6.0F;
  }
  return scene;
}

double anchor_search_ms(const Device& device, const Scene& scene) {
  const ParticleBuffers camera(device, scene.camera, Precision::kFloat);
  const ParticleBuffers lidar(device, scene.lidar, Precision::kFloat);
  AnchorStage anchor(device, Precision::kFloat, kAnchorNeighbours);
  const auto search = [&] {
    anchor.assign(camera, lidar, kAnchorReach_m);
    device.finish();
  };
  search();  // the first launches compile
  return time_ms(search);
}

class Case {
 public:
  Case(const Device& device, const Log& log, std::int64_t particles, int iterations)
      : device_(device), base_(fmt::format("training/{}k", particles / 1000)) {
    TrainingOptions training;
    training.frames.image_scale = 1.0;
    TrainOptions& options = training.train;
    options.iterations = 1000;
    options.lidar_every = 1;
    options.anchor = kPaperAnchors;
    options.densify.epochs = iterations + kWarmUp;  // no densification
    const Scene scene = bench_scene(particles);
    const double search_ms = anchor_search_ms(device, scene);
    device.reset_memory_peak();
    const std::uint64_t before = device.memory().now;
    const MemoryNeed reported = training_memory(device, log, scene, training);
    Trainer trainer(device, log, scene, training);
    for (int i = 0; i < kWarmUp; ++i) {
      trainer.step();
    }
    device.profile().reset();
    std::vector<double> samples;
    for (int i = 0; i + 1 < iterations; ++i) {
      samples.push_back(time_ms([&] {
        trainer.step();
        device_.finish();
      }));
    }
    std::map<std::string, double> stages;
    double all = 0.0;
    for (const ProfileRow& row : device.profile().rows()) {
      stages[stage_of(row.kernel)] += row.total_ms / static_cast<double>(samples.size());
      all += row.total_ms / static_cast<double>(samples.size());
    }
    for (const auto& [stage, ms] : stages) rows_.push_back({base_ + "/" + stage, ms, "ms", 0.0});
    const Spread iteration = spread_of(samples);
    rows_.push_back({base_ + "/iteration", iteration.median, "ms", iteration.half_iqr});
    rows_.push_back({base_ + "/anchor_search", search_ms, "ms", 0.0});
    rows_.push_back({base_ + "/anchor_share",
                     100.0 * (stages["anchor"] + search_ms / 1000.0) / (all + search_ms / 1000.0),
                     "%",
                     0.0});
    rows_.push_back({base_ + "/memory_peak", giga(device.memory().peak - before), "GB", 0.0});
    rows_.push_back({base_ + "/memory_told", giga(reported.total), "GB", 0.0});
  }
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }

 private:
  static constexpr int kWarmUp = 2;

  static double giga(std::uint64_t bytes) { return static_cast<double>(bytes) * 1e-9; }
  Device device_;
  std::string base_;
  std::vector<Row> rows_;
};

}  // namespace

std::vector<Row> run_training(const std::string& device_request,
                              const TrainingBenchOptions& options,
                              const Note& note) {
  const Device device = Device::best(device_request, {.profiling = true});
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const ScratchFolder scratch("simuli_bench");
  StreetOptions street;
  street.output = scratch.path() / "street.log";
  street.frames = 5;
  const Log log = synth_street(street);
  std::vector<Row> rows;
  for (const std::int64_t particles : options.particles) {
    note(fmt::format("{} particles in each set", particles));
    const Case one(device, log, particles, options.iterations);
    rows.insert(rows.end(), one.rows().begin(), one.rows().end());
  }
  return rows;
}

}  // namespace simuli::bench
