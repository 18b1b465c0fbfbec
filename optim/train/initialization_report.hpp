#pragma once
#include <string>
#include <vector>

namespace simuli {

/// Use of the initialisation cache by a training.
struct InitializationReport {
  double saved_s = 0.0;  // time in s that the cached steps took originally
  std::vector<std::string> damaged;  // one line for each unreadable file, which is computed again
};

}  // namespace simuli
