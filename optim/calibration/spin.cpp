#include "optim/calibration/spin.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "host/base/error.hpp"

namespace simuli::calibration {
namespace {

/// Median distance from planes along the path found; infinity, and why, when there is none.
double flatness(const std::vector<Returns>& sweeps, const OdometryOptions& options, std::string& reason) {
  try {
    return fit_of(sweeps, find_path(sweeps, options)).median_m;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kNumeric) throw;
    reason = error.what();
    return std::numeric_limits<double>::infinity();
  }
}

}  // namespace

SpinReport find_spin(const std::vector<Returns>& clockwise,
                     const std::vector<Returns>& counter_clockwise,
                     const OdometryOptions& options) {
  constexpr double kClear = 1.03;  // the wrong way is at least this much worse
  SpinReport report;
  report.clockwise_m = flatness(clockwise, options, report.reason);
  report.counter_clockwise_m = flatness(counter_clockwise, options, report.reason);
  if (report.counter_clockwise_m > kClear * report.clockwise_m) {
    report.spin = SpinDirection::kClockwise;
  } else if (report.clockwise_m > kClear * report.counter_clockwise_m) {
    report.spin = SpinDirection::kCounterClockwise;
  } else if (std::isfinite(report.clockwise_m)) {
    report.reason = fmt::format(
        "surfaces are {:.2f} cm thick if it turns clockwise and {:.2f} cm if not: the rig hardly moves",
        100.0 * report.clockwise_m,
        100.0 * report.counter_clockwise_m);
  }
  if (report.spin) report.reason.clear();
  return report;
}

}  // namespace simuli::calibration
