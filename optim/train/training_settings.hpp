#pragma once
// Options as text: what a scene's record and a checkpoint say of a training.
#include <string>
#include <vector>

#include "optim/train/training_options.hpp"

namespace simuli {

/// "key=value" of every option that `simuli train --set` takes, in a fixed order.
[[nodiscard]] std::vector<std::string> settings_of(const TrainingOptions& options);

/// The bundle that these options of a training are (training_options_of), or "custom".
[[nodiscard]] std::string quality_of(const RenderOptions& options);

/// The options of `simuli train --quality QUALITY --set SETTING...`: quality "" is balanced; settings are
/// "key=value" each. Error{kUsage} naming key, found and allowed.
[[nodiscard]] TrainingOptions training_options(const std::string& quality,
                                               const std::vector<std::string>& settings);

}  // namespace simuli
