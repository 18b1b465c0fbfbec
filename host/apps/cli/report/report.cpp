#include "host/apps/cli/report/report.hpp"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>
#include <utility>
#include <vector>

#include "host/apps/cli/base/counted.hpp"
#include "host/apps/cli/base/progress.hpp"
#include "host/apps/cli/base/provenance.hpp"
#include "host/apps/cli/draw/html_report.hpp"
#include "host/apps/cli/draw/pictures.hpp"
#include "host/apps/cli/report/eval_tables.hpp"
#include "host/apps/cli/report/report_parts.hpp"
#include "host/core/base/fields.hpp"
#include "host/core/base/version.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "optim/base/frames.hpp"
#include "optim/eval/held_out_scores.hpp"

namespace simuli::cli {
namespace {

constexpr std::size_t kPictures = 3;  // of each kind
constexpr int kProfiledFrames = 5;

std::string count_text(Eigen::Index count) {
  return fmt::format("{:.1f} k", static_cast<double>(count) / 1e3);
}

/// Adds the most important scores, above the pictures.
void add_scores(HtmlReport& html, const EvalReport& report) {
  const HeldOutScores scores = scores_of(report);
  std::vector<HtmlReport::Fact> facts;
  for (const ScoreLine& line : score_lines(scores)) {
    facts.push_back(
        {line.name + arrow(line.better), line.value + (line.unit.empty() ? "" : " " + line.unit)});
  }
  html.facts(compared_text(report.frames.label(), scores) + ". Better: \u2191 higher, \u2193 lower.", facts);
}

void add_metrics(HtmlReport& html, const EvalReport& report) {
  html.heading("Compared with the log");
  html.paragraph(compared_text(report.frames.label(), scores_of(report)) +
                 ". Better: \u2191 higher, \u2193 lower.");
  std::vector<std::vector<std::string>> rows;
  for (const ScoreLine& line : metric_lines(report)) {
    rows.push_back({line.name + arrow(line.better), line.value, line.unit});
  }
  html.table({"metric", "value", "unit"}, rows);
  for (const TextTable& table : eval_tables(report)) {
    std::vector<std::string> header;
    for (const TextColumn& column : table.header) header.push_back(column.name + arrow(column.better));
    html.paragraph(table.title + ":");
    html.table(header, table.rows);
  }
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

/// Splits "key=value" lines into rows.
std::vector<std::vector<std::string>> setting_rows(const std::vector<std::string>& lines) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& line : lines) {
    const std::size_t equals = line.find('=');
    rows.push_back({line.substr(0, equals), line.substr(std::min(line.size(), equals + 1))});
  }
  return rows;
}

void add_settings(HtmlReport& html,
                  const ReportText& text,
                  const Globals& globals,
                  const Evaluation& evaluation,
                  const EvalReport& report) {
  const RenderOptions& options = evaluation.options().render;
  const std::vector<std::string> unlike = unlike_training(evaluation.scene(), options);
  const EvalFrames& frames = report.frames;
  html.heading("Settings");
  std::vector<std::vector<std::string>> rows{
      {"edits", text.edits.empty() ? "none" : fmt::format("{}", fmt::join(text.edits, " "))},
      {"compared",
       fmt::format("{}, {} and {}",
                   frames.label(),
                   counted(report.images, "picture"),
                   counted(report.sweeps, "sweep"))},
      {"size of pictures", fmt::format("{} of the recorded", frames.requested.image_scale)},
      {"quality", quality_names()[static_cast<std::size_t>(globals.quality)]},
      {"unlike in training", unlike.empty() ? "nothing" : fmt::format("{}", fmt::join(unlike, ", "))},
      {"device", evaluation.device().info().label()},
      {"took", format_duration(report.seconds)}};
  html.text_table({"how it was rendered", ""}, rows);
  html.folded_table("All settings of rendering", {"setting", "value"}, setting_rows(lines_of(options)));
  if (!evaluation.scene().training) return;
  const TrainingRecord& made = *evaluation.scene().training;
  rows.clear();
  for (const RecordLine& line : record_lines(made)) rows.push_back({line.name, line.value});
  html.text_table({"how the scene was made", ""}, rows);
  html.folded_table("All settings of training", {"setting", "value"}, setting_rows(made.settings));
}

void add_training(HtmlReport& html, const TrainedReport& trained) {
  const TrainReport& r = trained.report.train;
  const TrainHistory& h = trained.history;
  html.heading("Training");
  html.paragraph(fmt::format(
      "{} iterations on {} pictures and {} sweeps: {} for the start, {} for the training. {} "
      "camera particles and {} "
      "LiDAR particles at the end; {} relocated, {} new, {} pruned. Ranges of LiDARs' rows corrected by up "
      "to {:.1f} cm.",
      r.last.iteration,
      r.images,
      r.sweeps,
      format_duration(trained.report.init.seconds),
      format_duration(r.seconds),
      count_text(r.camera_particles),
      count_text(r.lidar_particles),
      r.relocated,
      r.grown,
      r.pruned,
      100.0 * r.row_ranges_m));
  for (const std::string& line : r.warnings) html.paragraph("Warning: " + line);
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

void add_pictures(HtmlReport& html, Evaluation& evaluation) {
  const Log& log = evaluation.log();
  const std::vector<std::size_t> images = some_of(evaluation.frames().images, kPictures);
  if (images.empty() || evaluation.scene().scene.camera.size() == 0) return;
  html.heading(fmt::format("Pictures: {}", evaluation.frames().label()));
  html.paragraph(
      "Drag the line, or move it with the arrow keys. Errors: black is right, pale is off by a quarter of "
      "full scale or more.");
  for (const std::size_t index : images) {
    const ImageFrame& frame = log.images[index];
    const PicturePair pair = evaluation.picture(index);
    const std::string name = fmt::format("{}, picture {}, {:.2f} s", frame.camera, index, frame.time_start_s);
    html.compare(pair.rendered, "rendered", pair.recorded, "recorded", name, PictureCode::kPhoto);
    html.picture(error_picture(pair), name + ": error", PictureCode::kPhoto);
  }
}

void add_sweeps(HtmlReport& html, Evaluation& evaluation) {
  const Log& log = evaluation.log();
  const std::vector<std::size_t> sweeps = some_of(evaluation.frames().sweeps, kPictures);
  if (sweeps.empty() || evaluation.scene().scene.lidar.size() == 0) return;
  html.heading(fmt::format("Sweeps: {}", evaluation.frames().label()));
  html.paragraph(
      "Ranges by azimuth: warm near, cold far; black: no return; grey: the sensor has no ray there, or none "
      "that passes its ego vehicle.");
  for (const std::size_t index : sweeps) {
    const SweepFrame& frame = log.sweeps[index];
    const LidarModel& lidar = log.lidar(frame.lidar).model;
    const LidarPair sweep = evaluation.sweep(index);
    const PicturePair ranges = range_pictures(lidar, sweep);
    const std::string name = fmt::format("{}, sweep {}, {:.2f} s", frame.lidar, index, frame.time_start_s);
    html.compare(ranges.rendered, "rendered", ranges.recorded, "recorded", name + ": ranges");
    html.picture(
        range_error_image(lidar, sweep.recorded.rays, sweep.rendered.range, sweep.recorded.range),
        fmt::format("{}: error of ranges, black is right, pale is off by {:g} m or more; blue: returned, "
                    "but not in the scene; green: returns in the scene alone",
                    name,
                    kFullError_m));
  }
}

/// Returns the time of each kernel of one frame in ms, the slowest first.
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

void add_times(HtmlReport& html, const Evaluation& evaluation, SceneOnDevice& scene) {
  const Log& log = evaluation.log();
  const std::vector<std::string> header{"kernel", "ms a frame", "launches"};
  html.heading("Time on the device, by kernel");
  if (!log.images.empty() && scene.scene().camera.size() > 0) {
    const ImageFrame& frame = log.images.front();
    const Camera camera =
        scaled_camera(log.camera(frame.camera).model, evaluation.frames().requested.image_scale);
    html.paragraph(fmt::format("A picture of {}, {} x {} px:", frame.camera, camera.width, camera.height));
    html.table(header, kernel_times(scene, Sensor(camera), shot_of(log, frame)));
  }
  if (log.sweeps.empty() || scene.scene().lidar.size() == 0) return;
  const SweepFrame& frame = log.sweeps.front();
  const Sensor lidar(log.lidar(frame.lidar).model);
  html.paragraph(fmt::format("A sweep of {}, {} rays:", frame.lidar, lidar.ray_count()));
  html.table(header, kernel_times(scene, lidar, shot_of(log, frame)));
}

}  // namespace

void write_report(const std::filesystem::path& file,
                  const ReportText& text,
                  const Globals& globals,
                  Evaluation& evaluation,
                  const EvalReport& report) {
  const DeviceInfo& info = evaluation.device().info();
  HtmlReport html(text.title,
                  fmt::format("simuli {}; {}, driver {}", version(), info.label(), info.driver_version));
  SceneOnDevice scene(Device::best(globals.device, {.profiling = true}),
                      borrowed(evaluation.scene().scene),
                      evaluation.options().render);
  add_scores(html, report);
  add_pictures(html, evaluation);
  add_sweeps(html, evaluation);
  add_unrecorded(html, evaluation, scene);
  add_metrics(html, report);
  add_curves(html, report);
  if (text.trained != nullptr) add_training(html, *text.trained);
  add_settings(html, text, globals, evaluation, report);
  add_times(html, evaluation, scene);
  html.write(file);
}

}  // namespace simuli::cli
