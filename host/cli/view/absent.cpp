// The viewer, in a build without it.
#include "host/base/error.hpp"
#include "host/cli/base/commands.hpp"
#include "host/cli/view/view_server.hpp"

namespace simuli::cli {

void add_view(Command app, const Globals& /*globals*/) {
  add_absent(app, "view", "a scene in the browser (not in this build)", "SIMULI_VIEWER");
}

namespace {
SceneOnDevice no_scene() { refuse_absent("train --view", "SIMULI_VIEWER"); }
}  // namespace

ViewSession::ViewSession(const Globals& /*globals*/, SceneFile /*file*/)
    : scene_(no_scene()), asked_s_(0.0) {}
void ViewSession::show(Scene /*scene*/) {}
void ViewSession::set_progress(const ViewProgress& /*progress*/) {}
double ViewSession::idle_s() const { return 0.0; }

struct ViewServer::Impl {};
ViewServer::ViewServer(ViewSession& /*session*/, const ServerOptions& /*options*/) {}
ViewServer::~ViewServer() = default;
std::string ViewServer::url() const { return {}; }

}  // namespace simuli::cli
