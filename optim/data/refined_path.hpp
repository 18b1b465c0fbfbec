#pragma once
// Ego-pose refinement by LiDAR. Poses from GNSS/IMU or other registrations have errors of centimetres and
// hundredths of a degree, which would thicken the scene's surfaces.
#include <functional>
#include <string>

#include "io/log/log.hpp"
#include "optim/data/path_report.hpp"

namespace simuli {

struct RefinedLog {
  Log log;
  PathReport report;
};

/// Returns the log with the trajectory that calibration::align_log() finds with the recorded poses as a prior,
/// actors' boxes moved along, if sweeps are more consistent with common planes: the median distance at least 3
/// % smaller, and at most 2 % fewer returns on planes. Otherwise returns the unchanged log and the reason. All
/// sweeps count, including held-out ones: poses, unlike measurements, are known for them from the recorded
/// trajectory as well. A build without calibration changes nothing. progress(stage, done, total) as in
/// align_log().
[[nodiscard]] RefinedLog with_refined_path(
    Log log, const std::function<void(const std::string&, std::size_t, std::size_t)>& progress = {});

}  // namespace simuli
