#include "host/cli/report/report.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

#include "host/base/version.hpp"
#include "host/cli/base/progress.hpp"
#include "host/cli/report/held_out.hpp"
#include "host/cli/report/html_report.hpp"
#include "host/cli/report/tile_picture.hpp"
#include "host/render/rays/ray_grid.hpp"
#include "host/render/scene/scene_on_device.hpp"
#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

constexpr std::size_t kPictures = 3;  // of each kind
constexpr double kBirdsEye_m = 50.0;  // to each side
constexpr int kProfiledFrames = 5;

std::string count_text(Eigen::Index count) {
  return fmt::format("{:.1f} k", static_cast<double>(count) / 1e3);
}

void add_metrics(HtmlReport& html, const EvalReport& report) {
  html.heading("On frames that training did not see");
  html.paragraph(fmt::format("{} pictures of {} x {} px, {} sweeps.",
                             report.images,
                             report.image_width,
                             report.image_height,
                             report.sweeps));
  std::vector<std::vector<std::string>> rows;
  for (const MetricLine& line : metric_lines(report)) rows.push_back({line.name, line.value, line.unit});
  html.table({"metric", "value", "unit"}, rows);
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

void add_training(HtmlReport& html, const TrainedScene& trained) {
  const TrainReport& r = trained.training;
  const TrainHistory& h = trained.history;
  html.heading("Training");
  html.paragraph(
      fmt::format("{} iterations on {} pictures and {} sweeps: {} for the start, {} for the training. {} "
                  "camera particles and {} "
                  "LiDAR particles at the end; {} relocated, {} new.",
                  r.last.iteration,
                  r.images,
                  r.sweeps,
                  format_duration(trained.init.seconds),
                  format_duration(r.seconds),
                  count_text(r.camera_particles),
                  count_text(r.lidar_particles),
                  r.relocated,
                  r.grown));
  const char* const x = "iteration";
  html.chart("PSNR of training pictures, dB", x, {{"PSNR", h.iteration, h.psnr_db}});
  html.chart("mean distance error of training sweeps, cm",
             x,
             {{"distance", h.iteration, scaled(h.distance_m, 100.0)}});
  html.chart("ray-drop decisions right, %", x, {{"drop", h.iteration, scaled(h.drop_accuracy, 100.0)}});
  html.chart("particles, thousands",
             x,
             {{"camera set", h.iteration, scaled(h.camera_particles, 1e-3)},
              {"LiDAR set", h.iteration, scaled(h.lidar_particles, 1e-3)}});
  html.chart("device memory, MB", x, {{"memory", h.iteration, scaled(h.device_bytes, 1e-6)}});
}

double seconds_of(const Log& log, double time_s) {
  return log.world_from_rig.poses().empty() ? time_s : time_s - log.world_from_rig.start_s();
}

void add_pictures(HtmlReport& html, SceneOnDevice& scene, const Log& log, const EvalOptions& options) {
  const std::vector<std::size_t> images =
      some_of(select_frames(log.images, options.held_out_every, options.held_out_every > 0), kPictures);
  if (images.empty() || scene.scene().camera.size() == 0) return;
  html.heading("Held-out pictures");
  html.paragraph(
      "Drag the line. Error pictures: black is right, pale is off by a quarter of full scale or more.");
  for (const std::size_t index : images) {
    const ImageFrame& frame = log.images[index];
    const PicturePair pair = camera_pair(scene, log, index, options);
    html.compare(
        pair.rendered,
        "rendered",
        pair.recorded,
        "recorded",
        fmt::format("{}, picture {}, {:.2f} s", frame.camera, index, seconds_of(log, frame.time_start_s)));
    html.picture(error_picture(pair), "error of the picture above");
  }
}

void add_sweeps(HtmlReport& html, SceneOnDevice& scene, const Log& log, const EvalOptions& options) {
  const std::vector<std::size_t> sweeps =
      some_of(select_frames(log.sweeps, options.held_out_every, options.held_out_every > 0), kPictures);
  if (sweeps.empty() || scene.scene().lidar.size() == 0) return;
  html.heading("Held-out sweeps");
  for (const std::size_t index : sweeps) {
    const SweepFrame& frame = log.sweeps[index];
    const SweepPictures sweep = sweep_pair(scene, log, index);
    html.compare(
        sweep.ranges.rendered,
        "rendered",
        sweep.ranges.recorded,
        "recorded",
        fmt::format("{}, sweep {}, {:.2f} s: range of every ray, warm near, cold far, black: no return",
                    frame.lidar,
                    index,
                    seconds_of(log, frame.time_start_s)));
    if (index != sweeps.front()) continue;
    html.picture(
        birds_eye(log.lidar(frame.lidar).model, sweep, kBirdsEye_m),
        fmt::format("The same sweep from above, {:.0f} m to each side: recorded returns blue, simulated "
                    "ones orange, both white",
                    kBirdsEye_m));
  }
}

/// Milliseconds of each kernel of one frame, the most expensive first.
std::vector<std::vector<std::string>> kernel_times(SceneOnDevice& scene,
                                                   const Sensor& sensor,
                                                   const Shot& shot) {
  const auto render = [&] { scene.render(sensor, shot).wait(); };
  Profile& profile = scene.device().profile();
  render();  // kernels are compiled at their first launch
  profile.reset();
  for (int k = 0; k < kProfiledFrames; ++k) render();
  std::vector<std::vector<std::string>> rows;
  double sum_ms = 0.0;
  for (const ProfileRow& row : profile.rows()) {
    const double ms = row.total_ms / kProfiledFrames;
    sum_ms += ms;
    rows.push_back({row.kernel, fmt::format("{:.3f}", ms), std::to_string(row.count / kProfiledFrames)});
  }
  rows.push_back({"sum", fmt::format("{:.3f}", sum_ms), ""});
  return rows;
}

void add_times(HtmlReport& html, SceneOnDevice& scene, const Log& log, const EvalOptions& options) {
  const std::vector<std::string> header{"kernel", "ms a frame", "launches"};
  html.heading("Time on the device, by kernel");
  if (!log.images.empty() && scene.scene().camera.size() > 0) {
    const ImageFrame& frame = log.images.front();
    const Camera camera = scaled_camera(log.camera(frame.camera).model, options.image_scale);
    html.paragraph(fmt::format("A picture of {}, {} x {} px:", frame.camera, camera.width, camera.height));
    html.table(header, kernel_times(scene, Sensor(camera), shot_of(log, frame)));
  }
  if (log.sweeps.empty() || scene.scene().lidar.size() == 0) return;
  const SweepFrame& frame = log.sweeps.front();
  const Sensor lidar(log.lidar(frame.lidar).model);
  html.paragraph(fmt::format("A sweep of {}, {} rays:", frame.lidar, lidar.ray_count()));
  html.table(header, kernel_times(scene, lidar, shot_of(log, frame)));
  html.heading("How the LiDAR's rays fall into tiles");
  html.picture(
      tile_picture(make_ray_grid(scene.device(), lidar.lidar(), lidar.rays(), options.render), frame.lidar),
      "the beam pattern, the tiles over it, the rays of each tile");
}

}  // namespace

void write_report(const std::filesystem::path& file,
                  const std::string& title,
                  const Globals& globals,
                  const Log& log,
                  const Scene& scene,
                  const EvalOptions& options,
                  const EvalReport& report,
                  const TrainedScene* trained) {
  // One device for pictures and times.
  const Device device = Device::best(globals.device, {.profiling = true});
  HtmlReport html(
      title,
      fmt::format(
          "simuli {}; {}, driver {}", version(), device.info().label(), device.info().driver_version));
  add_metrics(html, report);
  if (trained != nullptr) add_training(html, *trained);
  SceneOnDevice on_device(device, borrowed(scene), options.render);
  add_pictures(html, on_device, log, options);
  add_sweeps(html, on_device, log, options);
  add_times(html, on_device, log, options);
  html.write(file);
}

void write_bench_report(const std::filesystem::path& file,
                        const std::string& title,
                        const std::vector<bench::Row>& rows) {
  HtmlReport html(title, std::string("simuli ") + version());
  std::vector<std::vector<std::string>> cells;
  std::string table;
  const auto flush = [&] {
    if (cells.empty()) return;
    html.heading(table);
    html.table({"measured", "value", "unit", "+-"}, cells);
    cells.clear();
  };
  for (const bench::Row& row : rows) {
    const std::string name = row.name.substr(0, row.name.rfind('/'));
    if (name != table) flush();
    table = name;
    cells.push_back({row.name.substr(std::min(row.name.size(), name.size() + 1)),
                     fmt::format("{:.5g}", row.value),
                     row.unit,
                     row.spread > 0.0 ? fmt::format("{:.2g}", row.spread) : ""});
  }
  flush();
  html.write(file);
}

}  // namespace simuli::cli
