#pragma once
// Text on the training of a scene.
#include <string>
#include <vector>

#include "host/device/render/options/options.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// Name and value of a main property of a training.
struct RecordLine {
  std::string name;
  std::string value;
};
/// Direction in which a score improves.
enum class Better { kNeither, kHigher, kLower };
/// Returns an arrow after a no-break space; "" for kNeither.
[[nodiscard]] std::string arrow(Better better);

/// A formatted score; value "-" without frames.
struct ScoreLine {
  std::string name;
  std::string value;
  std::string unit;
  Better better = Better::kNeither;
};
[[nodiscard]] ScoreLine psnr_line(double psnr_db);
[[nodiscard]] ScoreLine ssim_line(double ssim);
[[nodiscard]] ScoreLine distance_line(double median_m);
[[nodiscard]] ScoreLine intensity_line(double rmse);
[[nodiscard]] ScoreLine drop_line(double accuracy);
[[nodiscard]] ScoreLine chamfer_line(double chamfer_m);
/// Returns the main scores in the order of `simuli eval`.
[[nodiscard]] std::vector<ScoreLine> score_lines(const HeldOutScores& scores);
/// Returns "held-out frames: 4 pictures of 160 x 90 px, 4 sweeps".
[[nodiscard]] std::string compared_text(const std::string& frames, const HeldOutScores& scores);
/// Returns a heading and the scores with the names and the order of `simuli eval`.
[[nodiscard]] std::string text_of(const HeldOutScores& scores);
/// Returns "  PSNR   29.84 dB
/// ".
[[nodiscard]] std::string text_of(const ScoreLine& line);
[[nodiscard]] std::string number_text(double value, int decimals);

/// Returns "front 16 (4 held out), left none (20 held out)": numbers of training frames.
[[nodiscard]] std::string uses_text(const std::vector<SensorUse>& sensors);
[[nodiscard]] std::vector<RecordLine> record_lines(const TrainingRecord& record);

/// Returns "render.KEY=VALUE (trained with VALUE)" for each option that differs from the training; empty for
/// a scene without a record of its training.
[[nodiscard]] std::vector<std::string> unlike_training(const SceneFile& scene, const RenderOptions& options);
/// Prints one warning line to stderr if any option differs from the training.
void warn_unlike_training(const SceneFile& scene, const RenderOptions& options);

}  // namespace simuli::cli
