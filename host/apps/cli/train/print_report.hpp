#pragma once
// What `simuli train` says at its end.
#include <string>

#include "optim/train/training.hpp"

namespace simuli::cli {

/// On stdout, for people or as JSON; `scene`: the folder that was written.
void print_report(const TrainingReport& report, const std::string& scene, bool json);

}  // namespace simuli::cli
