#pragma once
// The command line that makes what the viewer shows.
#include <string>
#include <vector>

#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/view/view_request.hpp"
#include "host/core/sensors/sensor.hpp"

namespace simuli::cli {

/// Where the viewer's scene comes from.
struct ViewSource {
  std::string scene;  // as it was given on the command line
  Edits edits;
};

/// Where the request has a sensor on the rig, and whether that is where the scene has it, but for a shift to the
/// left.
struct SensorPlace {
  Pose rig_from_sensor;
  bool only_left = true;
};

/// `simuli render ...` of the request's picture or sweep: `sensor` as the scene has it, of which the picture
/// is a size, in that place at `time_s`; before it what writes the file of a free camera. `added`: options of the
/// actors that were added since. Error{kUsage} for edits of actors which the viewer's own command line edits, too.
[[nodiscard]] std::string command_of(const ViewRequest& request,
                                     double time_s,
                                     const Sensor& sensor,
                                     const SensorPlace& place,
                                     const ViewSource& source,
                                     const std::vector<std::string>& added);

}  // namespace simuli::cli
