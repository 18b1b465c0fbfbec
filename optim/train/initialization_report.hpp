#pragma once
#include <string>
#include <vector>

namespace simuli {

/// What of a start was kept from another one.
struct InitializationReport {
  double saved_s = 0.0;              // that its steps took then
  std::vector<std::string> damaged;  // a line for each file that could not be read, and is made anew
};

}  // namespace simuli
