// Used by builds without calibration.
#include <utility>

#include "optim/data/refined_path.hpp"

namespace simuli {

RefinedLog with_refined_path(
    Log log, const std::function<void(const std::string&, std::size_t, std::size_t)>& /*progress*/) {
  RefinedLog out{std::move(log), {}};
  out.report.reason = "this build has no calibration (CMake option SIMULI_CALIBRATION)";
  return out;
}

}  // namespace simuli
