#include "host/apps/cli/report/training.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <iostream>
#include <optional>
#include <utility>

#include "host/apps/cli/base/file_progress.hpp"
#include "host/apps/cli/base/interrupt.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/base/progress.hpp"
#include "host/apps/cli/report/eval_tables.hpp"
#include "host/apps/cli/view/live_page.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "host/core/base/stopwatch.hpp"
#include "io/base/event_file.hpp"
#include "io/scene/scene_parts.hpp"
#include "optim/eval/held_out_scores.hpp"

namespace simuli::cli {
namespace {

ProgressNote status_note(const TrainStatus& s, const MemoryUse& memory) {
  std::string text;
  if (std::isfinite(s.psnr_db)) text += fmt::format("PSNR {:.2f} dB  ", s.psnr_db);
  if (std::isfinite(s.distance_m)) {
    text += fmt::format(
        "mean distance error {:.1f} cm  drop {:.1f} %  ", 100.0 * s.distance_m, 100.0 * s.drop_accuracy);
  }
  text += fmt::format("{:.0f}k + {:.0f}k particles  {:.1f} GB",
                      static_cast<double>(s.camera_particles) / 1e3,
                      static_cast<double>(s.lidar_particles) / 1e3,
                      static_cast<double>(memory.now) / 1e9);
  return {std::move(text),
          {{"psnr_db", s.psnr_db},
           {"distance_m", s.distance_m},
           {"drop_accuracy", s.drop_accuracy},
           {"camera_particles", s.camera_particles},
           {"lidar_particles", s.lidar_particles},
           {"device_bytes", static_cast<double>(memory.now)}}};
}

/// Adds the estimated remaining time of a training of automatic length to its progress, which covers the
/// current stage only.
class Outlook {
 public:
  explicit Outlook(const Training& training)
      : length_(training.options().train.length), first_(training.status().iteration) {}
  void start_at(int iteration) {
    first_ = iteration;
    watch_ = Stopwatch();
  }
  [[nodiscard]] ProgressNote on(ProgressNote note, const TrainStatus& status) const {
    if (!length_.automatic) return note;
    const int done = status.iteration - first_;
    const double left_s = watch_.seconds() / std::max(done, 1) * (length_.most - status.iteration);
    note.text += fmt::format("  (or on, {} at most: {})", length_.most, format_duration(left_s));
    note.values.emplace_back("most", length_.most);
    note.values.emplace_back("left_at_most_s", left_s);
    return note;
  }

 private:
  const LengthOptions& length_;
  int first_;
  Stopwatch watch_;
};

/// Records states of a training at intervals, and writes them for TensorBoard if requested.
class Recorder {
 public:
  Recorder(TrainHistory& history, int iterations, const std::filesystem::path& event_folder)
      : history_(history), every_(std::max(1, iterations / TrainHistory::kPoints)) {
    if (!event_folder.empty()) events_.emplace(event_folder, now_s());
  }
  void add(const TrainStatus& s, const MemoryUse& memory) {
    if (s.iteration % every_ != 0 && s.iteration != s.planned) return;
    TrainHistory& h = history_;
    const auto put = [&](std::vector<double>& values, const char* tag, double value) {
      values.push_back(value);
      if (events_ && std::isfinite(value)) events_->scalar(tag, s.iteration, value, now_s());
    };
    h.iteration.push_back(s.iteration);
    put(h.psnr_db, "train/psnr_db", s.psnr_db);
    put(h.distance_m, "train/distance_m", s.distance_m);
    put(h.drop_accuracy, "train/drop_accuracy", s.drop_accuracy);
    put(h.camera_particles, "particles/camera", s.camera_particles);
    put(h.lidar_particles, "particles/lidar", s.lidar_particles);
    put(h.device_bytes, "memory/device_bytes", static_cast<double>(memory.now));
  }

 private:
  static double now_s() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  }
  TrainHistory& history_;
  int every_;
  std::optional<EventFile> events_;
};

void warn(const TrainReport& report) {
  if (report.rejected_gradients > 0) {
    std::cerr << fmt::format("simuli: warning: {} gradient entries were not finite and moved nothing\n",
                             report.rejected_gradients);
  }
  if (report.unsound_particles > 0 || report.unsound_losses > 0) {
    std::cerr << fmt::format(
        "simuli: warning: {} particles (left out) and the losses of {} frames were not finite\n",
        report.unsound_particles,
        report.unsound_losses);
  }
  for (const std::string& line : report.warnings) std::cerr << "simuli: warning: " << line << '\n';
  if (report.stopped_early) {
    std::cerr << fmt::format(
        "simuli: warning: stopped after {:.0f} s at iteration {} of {}; the learning rates had not run "
        "down\n",
        report.seconds,
        report.last.iteration,
        report.last.planned);
  }
}

std::string plan_text(const ChunkPlan& plan) {
  const std::string cut = plan.count > 1 ? fmt::format("{} stretches of {:.0f} m", plan.count, plan.length_m)
                                         : fmt::format("one piece of {:.0f} m", plan.length_m);
  return fmt::format(
      "simuli: the drive in {}: about {:.2f} GB of the host's memory, {:.2f} GB of the device's",
      cut,
      static_cast<double>(plan.host_bytes) * 1e-9,
      static_cast<double>(plan.device_bytes) * 1e-9);
}

/// Passes the newest scene of a training to the viewer while a page requests it.
class LiveScene {
 public:
  LiveScene(LivePage* view, const Training& training) : view_(view), training_(training) {
    update(training.status(), true);
  }
  /// `at_once`: also if no page requests it or little time has passed.
  void update(const TrainStatus& status, bool at_once = false) {
    if (view_ == nullptr) return;
    view_->set_progress({status.iteration < status.planned, status, status.planned});
    const auto now = std::chrono::steady_clock::now();
    const bool due = now - shown_ > kEvery && view_->idle_s() < kLooks_s;
    if (!due && !at_once) return;
    view_->show(training_.scene());
    shown_ = std::chrono::steady_clock::now();
  }

 private:
  static constexpr std::chrono::seconds kEvery{3};
  static constexpr double kLooks_s = 10.0;
  LivePage* view_;
  const Training& training_;
  std::chrono::steady_clock::time_point shown_;
};

[[noreturn]] void end_interrupted(Training& training, const Checkpoints& checkpoints) {
  training.save(checkpoints.file);
  throw Interrupted(fmt::format("interrupted at iteration {} of {}, state in {}; --resume goes on from there",
                                training.status().iteration,
                                training.status().planned,
                                checkpoints.file.string()));
}

/// Returns the unit of a share, or a note that the share is undefined.
const char* share_of(const char* unit, double value) {
  return std::isfinite(value) ? unit : "undefined: there are none";
}

}  // namespace

TrainHistory run_training(Training& training,
                          const Device& device,
                          const Globals& all_globals,
                          const TrainOutputs& outputs) {
  const Checkpoints& checkpoints = outputs.checkpoints;
  Ranks& ranks = *outputs.ranks;
  Globals globals = all_globals;
  if (!ranks.is_first()) globals.json = true, globals.json_progress = false;  // no progress
  std::error_code absent;
  const bool resumes = ranks.first(outputs.resume && std::filesystem::exists(checkpoints.file, absent));
  if (outputs.resume && !resumes && ranks.is_first()) {
    std::cerr << fmt::format("simuli: no checkpoint {}: from the start\n",
                             on_one_line(checkpoints.file.string()));
  }
  const ProgressStyle style = progress_style(globals);
  StageProgress stages(style);
  const auto tell = [&stages](const std::string& stage, std::size_t done, std::size_t total) {
    stages.update(stage, done, total);
  };
  if (resumes) {
    training.resume(checkpoints.file, tell);
  } else {
    training.prepare(tell);
  }
  stages.finish();
  // Printed only once the training is ready, so that a refused request prints a single line.
  if (style == ProgressStyle::kBar || style == ProgressStyle::kLines) {
    if (const double saved_s = training.report().start.saved_s; saved_s > 0.0)
      std::cerr << fmt::format("simuli: the start is kept from before: {} saved\n", format_duration(saved_s));
    if (!outputs.frames.empty()) std::cerr << fmt::format("simuli: frames to train on: {}\n", outputs.frames);
  }
  if (const ChunkPlan& plan = training.report().chunks; plan.count > 0 && ranks.is_first()) {
    std::cerr << plan_text(plan) << '\n';
  }
  TrainHistory history;
  const auto planned = [&training] { return static_cast<std::uint64_t>(training.status().planned); };
  // The first iteration compiles kernels that are not cached; its time is not representative.
  bool compiles = training.status().iteration < training.status().planned;
  if (compiles) stages.update("compile kernels", 0, 1);
  std::uint64_t end = planned();
  std::optional<Progress> progress;
  progress.emplace("train", end, style);
  Outlook outlook(training);
  std::optional<InterruptionPoint> interruption;
  if (checkpoints.every > 0) interruption.emplace();
  LiveScene live(outputs.view, training);
  Recorder recorder(history, training.status().planned, outputs.event_folder);
  const TrainReport& report =
      training
          .run(
              [&](const TrainStatus& status) {
                if (compiles) {
                  compiles = false;
                  stages.finish();
                  progress->start_at(static_cast<std::uint64_t>(status.iteration));
                  outlook.start_at(status.iteration);
                }
                if (planned() != end) {  // a training of automatic length has a progress bar per stage
                  progress->finish();
                  end = planned();
                  progress.emplace("train on", end, style);
                  progress->start_at(static_cast<std::uint64_t>(status.iteration));
                }
                progress->update(static_cast<std::uint64_t>(status.iteration),
                                 outlook.on(status_note(status, device.memory()), status));
                recorder.add(status, device.memory());
                live.update(status);
                if (interruption && ranks.any(interruption->is_requested_for())) {
                  end_interrupted(training, checkpoints);
                }
              },
              checkpoints)
          .train;
  stages.finish();
  progress->finish(status_note(report.last, device.memory()));
  live.update(report.last, true);
  if (ranks.is_first()) warn(report);
  return history;
}

SceneFile trained_scene(Training&& training, const Globals& globals) {
  StageProgress stages(progress_style(globals));
  stages.update("complete the scene", 0, 1);
  SceneFile scene = std::move(training).result();
  stages.finish();
  return scene;
}

EvalReport run_evaluation(Evaluation& evaluation,
                          const Globals& globals,
                          const std::filesystem::path& scene) {
  FileProgress progress("evaluate", globals);
  const EvalReport report = scene.empty() ? evaluation.run(progress.callback())
                                          : score_trained(evaluation, scene, progress.callback());
  progress.finish();
  return report;
}

std::vector<ScoreLine> metric_lines(const EvalReport& r) {
  const SweepMetrics& l = r.lidar;
  std::vector<ScoreLine> lines;
  using enum Better;
  const auto line =
      [&](const char* name, const std::string& value, const char* unit, Better better = kNeither) {
        lines.push_back({name, value, unit, better});
      };
  lines.push_back(psnr_line(r.psnr_db));
  line("  each picture's tint corrected", number_text(r.psnr_corrected_db, 2), "dB", kHigher);
  lines.push_back(ssim_line(r.ssim));
  line("FLIP", number_text(r.flip, 4), "", kLower);
  lines.push_back(distance_line(l.distance_median_m));
  line("  of expected distances", number_text(r.distance_expected_median_m * 100.0, 2), "cm", kLower);
  line("distance error, median squared", number_text(l.medl2_m2, 6), "m^2", kLower);
  line("distance error, mean rel. squared", number_text(l.mean_rel_l2, 5), "", kLower);
  lines.push_back(intensity_line(l.intensity_rmse));
  lines.push_back(drop_line(l.raydrop_accuracy));
  line("  if every ray returned", number_text(l.raydrop_trivial * 100.0, 2), "% of rays");
  line("  dropped rays found",
       number_text(l.drop_recall * 100.0, 2),
       share_of("% of dropped rays", l.drop_recall),
       kHigher);
  line("  correct drops",
       number_text(l.drop_precision * 100.0, 2),
       share_of("% of rays predicted to drop", l.drop_precision),
       kHigher);
  if (r.share_own > 0.0)
    line("rays on the ego vehicle, left out", number_text(r.share_own * 100.0, 2), "% of rays");
  line("Chamfer, squared", number_text(l.chamfer_m2, 4), "m^2", kLower);
  lines.push_back(chamfer_line(l.chamfer_m));
  if (r.actor_pixels + r.actor_returns > 0) {
    line("PSNR inside actors' boxes", number_text(r.actor_psnr_db, 2), "dB", kHigher);
    line("distance error there, median", number_text(r.actor_distance_median_m * 100.0, 2), "cm", kLower);
    line("returns there that end there", number_text(r.actor_share_met * 100.0, 2), "% of them", kHigher);
  }
  line("camera speed", number_text(r.camera_mp_per_s, 2), "MP/s", kHigher);
  line("LiDAR speed", number_text(r.lidar_mr_per_s, 2), "MR/s", kHigher);
  return lines;
}

void print_eval(const EvalReport& r, const SceneFile& scene, bool json, const EvalSupport* support) {
  if (json) {
    Json out = json_of(r);
    out["training"] = scene.training ? to_json(*scene.training) : Json();
    if (support != nullptr) out["support"] = json_of(*support);
    std::cout << json_text(out) << '\n';
    return;
  }
  std::cout << fmt::format("{}, on {}\n", compared_text(r.frames.label(), scores_of(r)), r.device);
  for (const ScoreLine& line : metric_lines(r)) std::cout << text_of(line);
  for (const TextTable& table : eval_tables(r)) std::cout << text_of(table);
  if (r.sweeps_without_distance + r.sweeps_without_chamfer > 0) {
    std::cout << fmt::format("  left out of means: {} sweeps without returns, {} without predicted points\n",
                             r.sweeps_without_distance,
                             r.sweeps_without_chamfer);
  }
  if (r.sweeps_without_drops + r.sweeps_without_predicted_drops > 0) {
    std::cout << fmt::format(
        "  left out of means: {} sweeps without dropped rays, {} without predicted ones\n",
        r.sweeps_without_drops,
        r.sweeps_without_predicted_drops);
  }
  if (support != nullptr) std::cout << text_of(*support);
}

}  // namespace simuli::cli
