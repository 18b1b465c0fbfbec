#include "bench/paper/table8.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "bench/paper/clipped.hpp"
#include "bench/paper/drive_log.hpp"
#include "host/core/base/fields.hpp"
#include "io/synth/street.hpp"
#include "optim/base/frames.hpp"
#include "optim/eval/sweep_pair.hpp"

namespace simuli::bench {
namespace {

struct Named {
  const char* name;
  Projection projection;
  Extent extent;
};
// The reference is the first column.
constexpr std::array<Named, 4> kColumns{{{"monte_carlo", Projection::kMonteCarlo, Extent::kUnscented},
                                         {"unscented", Projection::kUnscented, Extent::kUnscented},
                                         {"linearized", Projection::kLinearized, Extent::kUnscented},
                                         {"exact", Projection::kUnscented, Extent::kExact}}};
constexpr const Named& kUnscented = kColumns[1];
constexpr const Named& kExact = kColumns[3];
constexpr int kTimedSweeps = 7;

RenderOptions render_with(const Named& column) {
  RenderOptions options;
  options.projection = column.projection;
  options.extent = column.extent;
  return options;
}

struct Metric {
  const char* name;
  double SweepMetrics::*value;
  const char* unit;
};
constexpr std::array<Metric, 8> kMetrics{{{"medl2_m2", &SweepMetrics::medl2_m2, "m^2"},
                                          {"mean_rel_l2", &SweepMetrics::mean_rel_l2, "of 1"},
                                          {"intensity_rmse", &SweepMetrics::intensity_rmse, "of 1"},
                                          {"raydrop_accuracy", &SweepMetrics::raydrop_accuracy, "of rays"},
                                          {"raydrop_trivial", &SweepMetrics::raydrop_trivial, "of rays"},
                                          {"drop_recall", &SweepMetrics::drop_recall, "of dropped rays"},
                                          {"drop_precision", &SweepMetrics::drop_precision, "of said drops"},
                                          {"chamfer_m2", &SweepMetrics::chamfer_m2, "m^2"}}};

/// Returns the median of the values with half of their range.
Row middle(const std::string& name, const std::vector<double>& values, const char* unit) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {name, spread_of(values).median, unit, 0.5 * (*high - *low)};
}

/// The table for one particle size: trained with each projection, and one training rendered with each.
class Table8 {
 public:
  Table8(const Device& device,
         const Device& profiled,
         const Drive& drive,
         const Table8Options& options,
         Note note)
      : device_(device), profiled_(profiled), log_(drive.log), options_(options), note_(std::move(note)) {
    fields_of(training_).apply(drive.settings, "settings");
    held_out_ = HeldOutRule(log_, training_.frames).held_out(log_.sweeps);
  }

  void run(const std::string& name, double voxel_m, std::vector<Row>& rows) {
    TrainingOptions training = training_;
    training.init.voxel_m = voxel_m;
    training.init.max_scale_m = std::max(training.init.max_scale_m, voxel_m);
    training.init.max_shell = 0;
    training.init.sweep_depth = false;
    training.train.iterations = options_.iterations;
    SceneFile unscented;  // of the first seed
    Columns trained_with(kColumns.size());
    for (std::size_t c = 0; c < kColumns.size(); ++c) {
      training.train.render = render_with(kColumns[c]);
      const std::string base = fmt::format("{}/{}", name, kColumns[c].name);
      for (int seed = 1; seed <= options_.seeds; ++seed) {
        training.frames.seed = static_cast<std::uint64_t>(seed);
        SceneFile scene = fit(device_, log_, training);
        trained_with[c].push_back(metrics_of(scene, kColumns[c]));
        note_(fmt::format("{}, seed {}: {} particles", base, seed, scene.scene.lidar.size()));
        if (seed > 1) continue;
        add_costs(base, scene.scene, kColumns[c], rows);
        if (&kColumns[c] == &kUnscented) unscented = std::move(scene);
      }
    }
    add(name, trained_with, rows);
    Columns rendered_with;
    for (const Named& column : kColumns) {
      rendered_with.push_back({metrics_of(unscented, column)});
      add_costs(fmt::format("{}_render/{}", name, column.name), unscented.scene, column, rows);
    }
    add(name + "_render", rendered_with, rows);
  }

 private:
  using Columns = std::vector<std::vector<SweepMetrics>>;  // [columns][seeds]

  SweepMetrics metrics_of(const SceneFile& scene, const Named& column) {
    return compare(device_, log_, scene, {.timed_renders = 1, .render = render_with(column)}).lidar;
  }

  /// Returns the share of the light of held-out sweeps that these extents cut off relative to exact extents,
  /// in %.
  double clipped_percent(const Scene& scene, const Named& column) {
    SceneOnDevice exact(device_, borrowed(scene), render_with(kExact));
    SceneOnDevice other(device_, borrowed(scene), render_with(column));
    double whole = 0.0, found = 0.0;
    const auto gathered = [&](SceneOnDevice& on_device, const SweepFrame& frame) {
      double sum = 0.0;
      const SweepPair pair = render_sweep(on_device, log_, frame);
      for (const float left : pair.simulated.transmittance) sum += 1.0 - static_cast<double>(left);
      return sum;
    };
    for (const std::size_t index : held_out_) {
      whole += gathered(exact, log_.sweeps[index]);
      found += gathered(other, log_.sweeps[index]);
    }
    return 100.0 * (1.0 - found / whole);
  }

  /// Returns the device time of the projection of held-out sweeps.
  Spread projection_ms(const Scene& scene, const Named& column) {
    SceneOnDevice on_device(profiled_, borrowed(scene), render_with(column));
    std::vector<double> samples;
    for (int i = -1; i < kTimedSweeps; ++i) {
      const SweepFrame& frame = log_.sweeps[held_out_[static_cast<std::size_t>(i + 1) % held_out_.size()]];
      profiled_.profile().reset();
      static_cast<void>(render_sweep(on_device, log_, frame));
      double ms = 0.0;
      for (const ProfileRow& row : profiled_.profile().rows()) {
        if (row.kernel == "project") ms += row.total_ms;
      }
      if (i >= 0) samples.push_back(ms);  // the first launch compiles
    }
    return spread_of(std::move(samples));
  }

  void add_costs(const std::string& base, const Scene& scene, const Named& column, std::vector<Row>& rows) {
    rows.push_back({base + "/clipped", clipped_percent(scene, column), "%", 0.0});
    const Spread ms = projection_ms(scene, column);
    rows.push_back({base + "/projection_ms", ms.median, "ms", ms.half_iqr});
  }

  /// Adds each metric of each column, its difference to the reference with the same seed, and the spread of
  /// the reference over its seeds.
  static void add(const std::string& name, const Columns& columns, std::vector<Row>& rows) {
    const std::vector<SweepMetrics>& yardstick = columns.front();
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::string base = fmt::format("{}/{}", name, kColumns[c].name);
      for (const Metric& m : kMetrics) {
        std::vector<double> values, apart;
        for (std::size_t s = 0; s < columns[c].size(); ++s) {
          values.push_back(columns[c][s].*m.value);
          apart.push_back(100.0 * (values.back() / (yardstick[s].*m.value) - 1.0));
        }
        rows.push_back(middle(fmt::format("{}/{}", base, m.name), values, m.unit));
        const Row& here = rows.back();
        const double share = 100.0 * here.spread / here.value;
        rows.push_back(c == 0 ? Row{fmt::format("{}/{}_seeds", base, m.name), share, "%", 0.0}
                              : middle(fmt::format("{}/{}_from_monte_carlo", base, m.name), apart, "%"));
      }
    }
  }

  Device device_, profiled_;
  const Log& log_;
  Table8Options options_;
  Note note_;
  TrainingOptions training_;
  std::vector<std::size_t> held_out_;  // held-out sweeps
};

}  // namespace

std::vector<Row> run_table8(const std::string& device_request,
                            const Table8Options& options,
                            const Note& note) {
  const Device device = Device::best(device_request);
  // Profiling stores all events, so trainings use another device object.
  const Device profiled = Device::best(device_request, {.profiling = true});
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const ScratchFolder scratch("simuli_bench");
  StreetOptions street;
  street.output = scratch.path() / "street.log";
  street.image_width = street.image_height = 8;  // pictures are not used
  street.moving_car = false;                     // a static scene
  Drive drive =
      options.log.empty() ? Drive{"street", synth_street(street)} : open_drive(options.log, scratch.path());
  drive.log.images.clear();
  std::vector<Row> rows;
  Table8 table(device, profiled, drive, options, note);
  table.run("table8", options.voxel_m, rows);
  table.run("table8_coarse", options.coarse_voxel_m, rows);
  const std::vector<LogLidar>& lidars = drive.log.lidars;
  if (!lidars.empty()) add_clipped(device, lidars.front().with_rows(), note, rows);
  return rows;
}

}  // namespace simuli::bench
