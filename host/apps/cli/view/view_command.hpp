#pragma once
// The command line that renders the viewer's current view.
#include <string>
#include <vector>

#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/view/view_request.hpp"
#include "host/core/sensors/sensor.hpp"

namespace simuli::cli {

/// Origin of the viewer's scene.
struct ViewSource {
  std::string scene;  // as given on the command line
  Edits edits;
};

/// Mounting of the request's sensor on the rig, and whether it is the scene's mounting, except for a shift to
/// the left.
struct SensorPlace {
  Pose rig_from_sensor;
  bool only_left = true;
};

/// Returns the `simuli render ...` command of the request's picture or sweep, preceded by commands that write
/// the file of a free camera. `sensor`: the scene's, of which the picture is a resized version; `added`:
/// options for actors added since. Throws Error{kUsage} for edits of actors that the viewer's own command line
/// edits as well.
[[nodiscard]] std::string command_of(const ViewRequest& request,
                                     double time_s,
                                     const Sensor& sensor,
                                     const SensorPlace& place,
                                     const ViewSource& source,
                                     const std::vector<std::string>& added);

}  // namespace simuli::cli
