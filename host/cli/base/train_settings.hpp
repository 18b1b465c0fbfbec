#pragma once
// The keys of "simuli train --set key=value".
#include <vector>

#include "host/cli/base/settings.hpp"
#include "optim/train/training_options.hpp"

namespace simuli::cli {

/// All of them, render.* included, in a fixed order.
[[nodiscard]] std::vector<Setting> train_settings(TrainingOptions& options);

}  // namespace simuli::cli
