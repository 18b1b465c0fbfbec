#pragma once
#include <string>
#include <vector>

#include "optim/train/training_options.hpp"

namespace simuli {

/// The options of `simuli train --quality QUALITY --set SETTING...`: quality "" is balanced; settings are
/// "key=value" each. Error{kUsage} naming key, found and allowed.
[[nodiscard]] TrainingOptions training_options(const std::string& quality,
                                               const std::vector<std::string>& settings);

}  // namespace simuli
