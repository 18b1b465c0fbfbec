#pragma once
// What the commands say of how a scene was made.
#include <string>
#include <vector>

#include "host/device/render/options/options.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// Name and value of what matters most of a training, for people.
struct RecordLine {
  std::string name;
  std::string value;
};
/// Which of two scores is the better one.
enum class Better { kNeither, kHigher, kLower };
/// An arrow, behind a blank that no line is broken at; "" for kNeither.
[[nodiscard]] std::string arrow(Better better);

/// A score as people read it; "-" where there is no such frame.
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
/// What matters most, in the order of `simuli eval`.
[[nodiscard]] std::vector<ScoreLine> score_lines(const HeldOutScores& scores);
/// "held-out frames: 4 pictures of 160 x 90 px, 4 sweeps"
[[nodiscard]] std::string compared_text(const std::string& frames, const HeldOutScores& scores);
/// Of what a scene keeps, under the names and in the order of `simuli eval`, below a line that says of what.
[[nodiscard]] std::string text_of(const HeldOutScores& scores);
/// "  PSNR   29.84 dB\n"
[[nodiscard]] std::string text_of(const ScoreLine& line);
[[nodiscard]] std::string number_text(double value, int decimals);

/// "front 16 (4 held out), left none (20 held out)": frames that were trained on.
[[nodiscard]] std::string uses_text(const std::vector<SensorUse>& sensors);
[[nodiscard]] std::vector<RecordLine> record_lines(const TrainingRecord& record);

/// "render.KEY=VALUE (trained with VALUE)" of each option that the scene was not trained with; of a scene
/// that doesn't say none.
[[nodiscard]] std::vector<std::string> unlike_training(const SceneFile& scene, const RenderOptions& options);
/// One line on stderr when there are any: a scene is at its best as it was trained.
void warn_unlike_training(const SceneFile& scene, const RenderOptions& options);

}  // namespace simuli::cli
