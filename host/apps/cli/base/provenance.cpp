#include "host/apps/cli/base/provenance.hpp"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <map>
#include <set>

#include "host/apps/cli/base/counted.hpp"
#include "host/core/base/fields.hpp"
#include "host/device/render/options/quality.hpp"
#include "optim/train/training_options.hpp"

namespace simuli::cli {

namespace {

/// Returns the settings that differ from the defaults of the quality, without the ones printed elsewhere.
/// Keys of other versions are only counted, since their defaults are unknown.
std::string settings_text(const TrainingRecord& r) {
  const std::set<std::string> printed_elsewhere{"image_scale",
                                                "held_out_every",
                                                "held_out_middle",
                                                "held_out_last",
                                                "held_out_sensors",
                                                "seed",
                                                "iterations"};
  TrainingOptions defaults = training_options(find_quality(r.quality) ? r.quality : "", {});
  const Fields fields = fields_of(defaults);
  std::vector<std::string> others;
  std::size_t unknown = 0;
  for (const std::string& line : r.settings) {
    const std::string key = line.substr(0, line.find('='));
    const Field* const field = fields.find(key);
    if (field == nullptr) {
      ++unknown;
    } else if (!printed_elsewhere.contains(key) && line != key + '=' + field->text()) {
      others.push_back(line);
    }
  }
  const std::string text = others.empty() ? "defaults" : fmt::format("{}", fmt::join(others, " "));
  return unknown == 0 ? text : fmt::format("{} ({} unknown to this version: --json)", text, unknown);
}

}  // namespace

std::string number_text(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

std::string arrow(Better better) {
  if (better == Better::kNeither) return "";
  return better == Better::kHigher ? "\u00a0\u2191" : "\u00a0\u2193";
}

ScoreLine psnr_line(double psnr_db) { return {"PSNR", number_text(psnr_db, 2), "dB", Better::kHigher}; }
ScoreLine ssim_line(double ssim) { return {"SSIM", number_text(ssim, 4), "", Better::kHigher}; }
ScoreLine distance_line(double median_m) {
  return {"distance error, median", number_text(median_m * 100.0, 2), "cm", Better::kLower};
}
ScoreLine intensity_line(double rmse) {
  return {"intensity error, RMS", number_text(rmse, 4), "of 1", Better::kLower};
}
ScoreLine drop_line(double accuracy) {
  return {"ray drop, right decisions", number_text(accuracy * 100.0, 2), "% of rays", Better::kHigher};
}
ScoreLine chamfer_line(double chamfer_m) {
  return {"Chamfer, mean of both ways", number_text(chamfer_m, 4), "m", Better::kLower};
}

std::vector<ScoreLine> score_lines(const HeldOutScores& s) {
  std::vector<ScoreLine> lines;
  if (s.images > 0) lines.insert(lines.end(), {psnr_line(s.psnr_db), ssim_line(s.ssim)});
  if (s.sweeps > 0) {
    lines.insert(lines.end(),
                 {distance_line(s.distance_median_m),
                  intensity_line(s.intensity_rmse),
                  drop_line(s.raydrop_accuracy),
                  chamfer_line(s.chamfer_m)});
  }
  return lines;
}

std::string text_of(const ScoreLine& line) {
  return fmt::format("  {:<34} {:>10}{}{}\n", line.name, line.value, line.unit.empty() ? "" : " ", line.unit);
}

std::string compared_text(const std::string& frames, const HeldOutScores& s) {
  return fmt::format("{}: {} of {} x {} px, {}",
                     frames,
                     counted(s.images, "picture"),
                     s.image_width,
                     s.image_height,
                     counted(s.sweeps, "sweep"));
}

std::string text_of(const HeldOutScores& s) {
  std::string text = compared_text("held-out frames", s) + '\n';
  for (const ScoreLine& line : score_lines(s)) text += text_of(line);
  return text;
}

std::string uses_text(const std::vector<SensorUse>& sensors) {
  std::vector<std::string> texts;
  for (const SensorUse& use : sensors) {
    const std::string training = use.training == 0 ? "none" : fmt::format("{}", use.training);
    const std::string rest = use.held_out == 0 ? "" : fmt::format(" ({} held out)", use.held_out);
    texts.push_back(fmt::format("{} {}{}", use.sensor, training, rest));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::vector<RecordLine> record_lines(const TrainingRecord& r) {
  const FrameSelection& f = r.frames;
  const std::string held_out = held_out_text(f);
  const std::string iterations = r.iterations == r.planned_iterations
                                     ? fmt::format("{}", r.iterations)
                                     : fmt::format("{} of {}", r.iterations, r.planned_iterations);
  return {{"log", fmt::format("{} ({})", r.log_name, r.log_hash)},
          {"iterations", iterations},
          {"size of pictures", fmt::format("{} of the recorded", f.image_scale)},
          {"held out", held_out.empty() ? "nothing" : held_out},
          {"trained on", r.sensors.empty() ? "unknown" : uses_text(r.sensors)},
          {"seed", fmt::format("{}", f.seed)},
          {"quality", r.quality},
          {"settings", settings_text(r)},
          {"by", fmt::format("simuli {} on {}, driver {}", r.version, r.device, r.driver)}};
}

std::vector<std::string> unlike_training(const SceneFile& scene, const RenderOptions& options) {
  std::vector<std::string> unlike;
  if (!scene.training) return unlike;
  std::map<std::string, std::string> trained;  // by key
  for (const std::string& line : scene.training->settings) {
    const std::size_t equals = line.find('=');
    if (equals != std::string::npos) trained[line.substr(0, equals)] = line.substr(equals + 1);
  }
  RenderOptions usual;
  const Fields defaults = fields_of(usual);
  for (const Field& field : defaults.all()) {
    if (field.in_training == InTraining::kNoGradients) trained.emplace(field.key, field.text());
  }
  // The training may have used the filter of the scene.
  trained["render.camera_filter_px2"] = fmt::format("{}", scene.scene.camera_filter_px2);
  RenderOptions own = options;
  own.camera_filter_px2 = camera_filter_px2(options, scene.scene.camera_filter_px2);
  const Fields fields = fields_of(own);
  for (const Field& field : fields.all()) {
    const auto known = trained.find(field.key);
    if (known == trained.end() || known->second == field.text()) continue;
    unlike.push_back(fmt::format("{}={} (trained with {})", field.key, field.text(), known->second));
  }
  return unlike;
}

void warn_unlike_training(const SceneFile& scene, const RenderOptions& options) {
  const std::vector<std::string> unlike = unlike_training(scene, options);
  if (unlike.empty()) return;
  std::cerr << fmt::format("simuli: warning: the best quality needs the options of the training; found {}\n",
                           fmt::join(unlike, ", "));
}

}  // namespace simuli::cli
