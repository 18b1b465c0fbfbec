#pragma once
// Detection of diverged trainings.
#include <string>
#include <vector>

#include "optim/train/train_report.hpp"

namespace simuli {

struct Judgement {
  std::vector<std::string> warnings;  // one line each
  std::string failure;  // reason why the scene is unusable; empty: usable
};

/// Judges a training by its errors on training frames at the end against the start. Short trainings get no
/// verdict.
[[nodiscard]] Judgement judge(const TrainReport& report);

}  // namespace simuli
