// Calibration commands of a build without calibration.
#include "host/apps/cli/base/commands.hpp"

namespace simuli::cli {

void add_align(Command app, const Globals& /*globals*/) {
  add_absent(app, "align", "estimate a log's trajectory (not in this build)", "SIMULI_CALIBRATION");
}

void add_fit(Command app, const Globals& /*globals*/) {
  add_absent(app, "fit", "fit a sensor model (not in this build)", "SIMULI_CALIBRATION");
}

}  // namespace simuli::cli
