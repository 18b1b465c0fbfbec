// The commands of calibration, in a build without it.
#include "host/apps/cli/base/commands.hpp"

namespace simuli::cli {

void add_align(Command app, const Globals& /*globals*/) {
  add_absent(app, "align", "find a log's path (not in this build)", "SIMULI_CALIBRATION");
}

void add_fit(Command app, const Globals& /*globals*/) {
  add_absent(app, "fit", "fit a sensor model (not in this build)", "SIMULI_CALIBRATION");
}

}  // namespace simuli::cli
