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
/// "front 16 (4 held out), left none (20 held out)": frames that were trained on.
[[nodiscard]] std::string uses_text(const std::vector<SensorUse>& sensors);
[[nodiscard]] std::vector<RecordLine> record_lines(const TrainingRecord& record);

/// "render.KEY=VALUE (trained with VALUE)" of each option that the scene was not trained with; of a scene
/// that doesn't say none.
[[nodiscard]] std::vector<std::string> unlike_training(const SceneFile& scene, const RenderOptions& options);
/// One line on stderr when there are any: a scene is at its best as it was trained.
void warn_unlike_training(const SceneFile& scene, const RenderOptions& options);

}  // namespace simuli::cli
