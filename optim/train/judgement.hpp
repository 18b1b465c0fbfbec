#pragma once
// Whether a training has come to a scene that can be trusted.
#include <string>
#include <vector>

#include "optim/train/train_report.hpp"

namespace simuli {

struct Judgement {
  std::vector<std::string> warnings;  // a line each
  std::string failure;                // why there is no scene in it; empty: there is one
};

/// By how the training frames were met at the end, against the start. Of a few iterations nothing is said.
[[nodiscard]] Judgement judge(const TrainReport& report);

}  // namespace simuli
