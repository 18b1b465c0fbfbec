#pragma once
// The path of a log as its LiDAR sees it. Poses from GNSS/IMU or from another registration are centimetres
// and hundredths of a degree off, which is what a scene's surfaces are then thick.
#include <functional>
#include <string>

#include "io/log/log.hpp"
#include "optim/data/path_report.hpp"

namespace simuli {

struct RefinedLog {
  Log log;
  PathReport report;
};

/// The log on the path that calibration::align_log() finds with the recorded poses as a prior, boxes of
/// actors carried along, where its sweeps lie on common planes better there: the median distance at least 3 %
/// smaller, and no more than 2 % fewer returns on planes. Else as it is, and the reason. All sweeps count,
/// held-out ones too: this is where frames were taken, of which a recorded path tells as well, not what they
/// show. A build without calibration leaves logs as they are. progress(stage, done, total) as of align_log().
[[nodiscard]] RefinedLog with_refined_path(
    Log log, const std::function<void(const std::string&, std::size_t, std::size_t)>& progress = {});

}  // namespace simuli
