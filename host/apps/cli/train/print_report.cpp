#include "host/apps/cli/train/print_report.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <vector>

#include "host/apps/cli/base/counted.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/base/provenance.hpp"
#include "host/apps/cli/base/quoted.hpp"
#include "host/core/base/one_line.hpp"
#include "io/scene/scene_parts.hpp"

namespace simuli::cli {
namespace {

Json json_of(const std::vector<LengthStage>& stages) {
  Json out = Json::array();
  for (const LengthStage& s : stages) {
    out.push_back({{"iterations", s.iterations},
                   {"square", s.square},
                   {"lidar_loss", s.lidar_loss},
                   {"gain_db", s.gain_db},
                   {"gain_share", s.gain_share}});
  }
  return out;
}

std::string stages_text(const std::vector<LengthStage>& stages) {
  std::string text;
  for (const LengthStage& s : stages) {
    text += fmt::format("  {} iterations", s.iterations);
    if (&s != &stages.front()) {
      text += fmt::format(": per doubling {:+.2f} dB of training pictures, LiDAR loss {:+.1f} %",
                          s.gain_db,
                          -100.0 * s.gain_share);
    }
    text += '\n';
  }
  return text;
}

/// Returns a line on the ranks; empty for a training with one rank.
std::string ranks_text(const TrainReport& r) {
  if (r.ranks == 1) return "";
  const int iterations = std::max(1, r.last.iteration - r.first_iteration);
  return fmt::format("  {} ranks, {:.2f} MB of shards gathered a step\n",
                     r.ranks,
                     static_cast<double>(r.gathered_bytes) * 1e-6 / iterations);
}

/// Returns a line on ego-pose refinement; empty if it was not requested.
std::string path_text(const PathReport& path) {
  if (path.sweeps == 0)
    return path.reason.empty() ? "" : fmt::format("  path as recorded: {}\n", path.reason);
  const std::string fit = fmt::format("surfaces {:.2f} cm thick, {:.2f} cm on the refined path",
                                      100.0 * path.recorded_m,
                                      100.0 * path.refined_m);
  if (!path.used)
    return fmt::format("  path as recorded: {} ({}; {:.1f} s)\n", path.reason, fit, path.seconds);
  return fmt::format(
      "  path refined by up to {:.1f} cm: {}; {:.1f} s\n", 100.0 * path.largest_change_m, fit, path.seconds);
}

/// Returns the suggested next commands.
std::string next_text(const EndedTraining& ended) {
  const std::string scene = shell_word(ended.scene);
  std::string text;
  if (!ended.report.empty()) text += fmt::format("report  {}\n", on_one_line(ended.report));
  text += fmt::format("next    simuli view {}\n", scene);
  if (ended.report.empty()) {
    text += fmt::format("        simuli eval {} {}{} --report {}\n",
                        scene,
                        shell_word(ended.log),
                        ended.held_out ? "" : " --held-out 0",
                        shell_word(std::filesystem::path(ended.scene).replace_extension(".html").string()));
  }
  return text;
}

}  // namespace

void print_report(const EndedTraining& ended, bool json) {
  const TrainingReport& report = ended.training;
  const TrainReport& r = report.train;
  const InitReport& init = report.init;
  const FindReport& found = report.found;
  const PathReport& path = report.path;
  if (json) {
    const Json out = {{"scene", ended.scene},
                      {"iterations", r.last.iteration},
                      {"stretches", report.chunks.count},
                      {"stretch_m", report.chunks.length_m},
                      {"foretold_host_bytes", report.chunks.host_bytes},
                      {"foretold_device_bytes", report.chunks.device_bytes},
                      {"stopped_early", r.stopped_early},
                      {"stages", json_of(r.stages)},
                      {"images", r.images},
                      {"sweeps", r.sweeps},
                      {"camera_particles", ended.camera_particles},
                      {"lidar_particles", ended.lidar_particles},
                      {"path_refined", path.used},
                      {"path_recorded_m", path.recorded_m},
                      {"path_refined_m", path.refined_m},
                      {"path_largest_change_m", path.largest_change_m},
                      {"path_seconds", path.seconds},
                      {"found_actors", found.actors},
                      {"added_actors", found.added},
                      {"continued_labels", found.continued},
                      {"moving_returns", found.moving_returns},
                      {"moving_returns_on_actors", found.moving_on_actors},
                      {"find_seconds", found.seconds},
                      {"depth_points", init.depth_points},
                      {"wall_points", init.wall_points},
                      {"ground_points", init.ground_points},
                      {"moving_points", init.moving_points},
                      {"train_psnr_db", r.last.psnr_db},
                      {"train_distance_m", r.last.distance_m},
                      {"train_drop_accuracy", r.last.drop_accuracy},
                      {"relocated", r.relocated},
                      {"grown", r.grown},
                      {"pruned", r.pruned},
                      {"row_ranges_m", r.row_ranges_m},
                      {"lidar_cells", init.lidar_cells},
                      {"lidar_thinned", init.lidar_thinned},
                      {"anchor_m", r.anchor_m},
                      {"rejected_gradients", r.rejected_gradients},
                      {"unsound_particles", r.unsound_particles},
                      {"unsound_losses", r.unsound_losses},
                      {"warnings", r.warnings},
                      {"ranks", r.ranks},
                      {"gathered_bytes", r.gathered_bytes},
                      {"init_seconds", init.seconds},
                      {"saved_seconds", report.start.saved_s},
                      {"seconds", r.seconds},
                      {"held_out", ended.held_out ? to_json(*ended.held_out) : Json()},
                      {"report", ended.report.empty() ? Json() : Json(ended.report)}};
    std::cout << json_text(out) << '\n';
    return;
  }
  std::cout
      << fmt::format("scene {}\n  {} on {} and {}: {:.1f} s to initialise, {:.1f} s to train\n",
                     on_one_line(ended.scene),
                     counted(r.last.iteration, "iteration"),
                     counted(r.images, "image"),
                     counted(r.sweeps, "sweep"),
                     init.seconds,
                     r.seconds)
      << ranks_text(r) << stages_text(r.stages) << path_text(path)
      << (found.sweeps == 0 ? ""
                            : fmt::format("  {} found in {:.1f} s, with {} of {} returns that moved; {} of "
                                          "them have no label, {} labels go on where they had ended\n",
                                          counted(found.actors, "moving thing"),
                                          found.seconds,
                                          found.moving_on_actors,
                                          found.moving_returns,
                                          found.added,
                                          found.continued))
      << fmt::format(
             "  camera set {} particles ({} of them the far shell, {} where only the laser saw what is "
             "there), LiDAR set {} particles ({} of them on surfaces that return nothing; and {} on walls "
             "above)\n",
             ended.camera_particles,
             init.shell_particles,
             init.filled_particles,
             ended.lidar_particles,
             init.dark_points,
             init.unmet_points)
      << fmt::format("  {} relocated, {} new, {} pruned; ranges of rows corrected by up to {:.1f} cm{}\n",
                     r.relocated,
                     r.grown,
                     r.pruned,
                     100.0 * r.row_ranges_m,
                     r.anchor_m > 0.0 ? fmt::format("; anchors {:.1f} cm away", 100.0 * r.anchor_m) : "")
      << fmt::format(
             "  left out: {} points that moved, {} thinned from the LiDAR set, {} from the "
             "camera set, {} that no image saw, {} that none shows apart from others\n",
             init.moving_points,
             init.lidar_thinned,
             init.camera_thinned,
             init.unseen_points,
             init.joined_points)
      << (ended.held_out ? text_of(*ended.held_out) : "no frame was held out: no scores\n")
      << next_text(ended);
}

}  // namespace simuli::cli
