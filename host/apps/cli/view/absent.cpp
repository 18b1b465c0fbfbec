// The viewer, in a build without it.
#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/view/live_page.hpp"

namespace simuli::cli {

void add_view(Command app, const Globals& /*globals*/) {
  add_absent(app, "view", "a scene in the browser (not in this build)", "SIMULI_VIEWER");
}

std::unique_ptr<LivePage> open_live_page(const Globals& /*globals*/, SceneFile /*file*/, int /*port*/) {
  refuse_absent("train --view", "SIMULI_VIEWER");
}

}  // namespace simuli::cli
