#include "bench/paper/table5.hpp"

#include <fmt/format.h>
#include <utility>

#include "bench/paper/drive_log.hpp"
#include "bench/paper/unified.hpp"
#include "host/core/base/fields.hpp"
#include "io/synth/street.hpp"
#include "optim/init/initialize.hpp"

namespace simuli::bench {
namespace {

constexpr int kEnvironmentWidth = 256;  // texels of 1.4 degrees

class Table5 {
 public:
  Table5(const Device& device, const Drive& drive, const Table5Options& options, Note note)
      : device_(device), log_(drive.log), note_(std::move(note)) {
    if (options.log.empty()) training_.init.voxel_m = 0.2;
    training_.init.environment_width = kEnvironmentWidth;
    training_.train.iterations = options.iterations;
    training_.train.render = paper_options();
    training_.train.appearance.color_grids = ColorGridsOf::kPictures;
    training_.train.anchor = kPaperAnchors;
    fields_of(training_).apply(drive.settings, "settings");
  }

  void add_unified(double distance_weight) {
    if (start_.camera.size() == 0) start_ = initialize_scene(log_, training_.frames, training_.init).scene;
    Scene scene = fit_unified(device_, log_, start_, training_, distance_weight);
    add(fmt::format("unified_{}", distance_weight),
        {std::move(scene), log_.cameras, log_.lidars, log_.world_from_rig});
  }
  void add_factorised(const char* name, const TrainingOptions& options) {
    add(name, fit(device_, log_, options));
  }
  [[nodiscard]] const TrainingOptions& options() const { return training_; }
  [[nodiscard]] std::vector<Row> rows() && { return std::move(rows_); }

 private:
  void add(const std::string& name, const SceneFile& file) {
    const EvalReport report = compare(device_,
                                      log_,
                                      file,
                                      {.image_scale = training_.frames.image_scale,
                                       .held_out_every = training_.frames.held_out_every,
                                       .timed_renders = 11,
                                       .render = training_.train.render});
    const auto row = [&](const char* metric, double value, const char* unit) {
      rows_.push_back({fmt::format("table5/{}/{}", name, metric), value, unit, 0.0});
    };
    row("psnr_db", report.psnr_db, "dB");
    row("chamfer_m2", report.lidar.chamfer_m2, "m^2");
    row("distance_median_cm", 100.0 * report.lidar.distance_median_m, "cm");
    row("camera_mp_per_s", report.camera_mp_per_s, "MP/s");
    row("lidar_mr_per_s", report.lidar_mr_per_s, "MR/s");
    row("particles", static_cast<double>(file.scene.lidar.size()), "in the LiDAR's set");
    note_(fmt::format("{}: PSNR {:.2f} dB, Chamfer {:.4g} m^2, {:.1f} MR/s",
                      name,
                      report.psnr_db,
                      report.lidar.chamfer_m2,
                      report.lidar_mr_per_s));
  }

  Device device_;
  const Log& log_;
  Note note_;
  TrainingOptions training_;
  Scene start_;  // initial scene of the unified sets
  std::vector<Row> rows_;
};

}  // namespace

std::vector<Row> run_table5(const std::string& device_request,
                            const Table5Options& options,
                            const Note& note) {
  const Device device = Device::best(device_request);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const ScratchFolder scratch("simuli_bench");
  StreetOptions street;
  street.output = scratch.path() / "street.log";
  street.moving_car = false;  // a static scene
  const Drive drive = options.log.empty() ? Drive{"street", synth_street(street), {"image_scale=1"}}
                                          : open_drive(options.log, scratch.path());
  Table5 table(device, drive, options, note);
  for (const double weight : {0.0, 0.001, 0.01, 0.1}) table.add_unified(weight);
  TrainingOptions without_grid = table.options();
  without_grid.train.appearance.color_grids = ColorGridsOf::kNone;
  table.add_factorised("without_grid", without_grid);
  TrainingOptions without_environment = table.options();
  without_environment.init.environment_width = 0;
  table.add_factorised("without_environment", without_environment);
  TrainingOptions without_anchor = table.options();
  without_anchor.train.anchor.weight = 0.0;
  table.add_factorised("without_anchor", without_anchor);
  table.add_factorised("full", table.options());
  return std::move(table).rows();
}

}  // namespace simuli::bench
