#include "optim/calibration/path/spin.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "host/core/base/error.hpp"

namespace simuli::calibration {
namespace {

constexpr double kTurnAt_m = 10.0;  // lever arm of rotations

struct Attempt {
  double median_m = std::numeric_limits<double>::infinity();  // of points to planes
  double motion_m = 0.0;                                      // mean over the sweeps
};

/// The trajectory for one direction; infinite distance and the reason on failure.
Attempt attempt(const std::vector<Returns>& sweeps, const OdometryOptions& options, std::string& reason) {
  Attempt out;
  try {
    const std::vector<TimedPose> path = find_path(sweeps, options);
    out.median_m = fit_of(sweeps, path).median_m;
    for (std::size_t i = 1; i < path.size(); ++i) {
      const Pose step = path[i - 1].pose.inverse() * path[i].pose;
      const double moved_m =
          step.translation.norm() + kTurnAt_m * step.rotation.angularDistance(Eigen::Quaterniond::Identity());
      out.motion_m += moved_m / static_cast<double>(path.size() - 1);
    }
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kNumeric) throw;
    reason = error.what();
  }
  return out;
}

}  // namespace

SpinReport find_spin(const std::vector<Returns>& clockwise,
                     const std::vector<Returns>& counter_clockwise,
                     const OdometryOptions& options) {
  constexpr double kClear = 1.03;  // required ratio of the wrong direction's distance
  // The wrong direction displaces points by up to the motion during a sweep: smaller motion is hidden by the
  // thickness of surfaces and by errors of the knots, some millimetres each.
  constexpr double kLeastMotion_m = 0.05;
  SpinReport report;
  const Attempt one = attempt(clockwise, options, report.reason);
  const Attempt other = attempt(counter_clockwise, options, report.reason);
  report.clockwise_m = one.median_m;
  report.counter_clockwise_m = other.median_m;
  const double motion_m = std::max(one.motion_m, other.motion_m);
  const bool any = std::isfinite(std::min(one.median_m, other.median_m));
  if (any && !(motion_m >= kLeastMotion_m)) {
    report.reason = fmt::format("the rig hardly moves: {:.1f} cm a sweep, allowed at least {:.0f} cm",
                                100.0 * motion_m,
                                100.0 * kLeastMotion_m);
  } else if (other.median_m > kClear * one.median_m) {
    report.spin = SpinDirection::kClockwise;
  } else if (one.median_m > kClear * other.median_m) {
    report.spin = SpinDirection::kCounterClockwise;
  } else if (any) {
    report.reason = fmt::format("surfaces are {:.2f} cm thick if it turns clockwise and {:.2f} cm if not",
                                100.0 * one.median_m,
                                100.0 * other.median_m);
  }
  if (report.spin) report.reason.clear();
  return report;
}

}  // namespace simuli::calibration
