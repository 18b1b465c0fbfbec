// simuli view: a scene in the browser.
#include <iostream>
#include <memory>

#include "host/base/error.hpp"
#include "host/cli/base/commands.hpp"
#include "host/cli/base/edits.hpp"
#include "host/cli/view/view_server.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {
namespace {

struct ViewCommand {
  std::string scene;
  Edits edits;
  ServerOptions server;
};

void view(const ViewCommand& command, const Globals& globals) {
  SceneFile file = read_scene(command.scene);
  if (file.world_from_rig.poses().empty()) {
    throw_input_error(command.scene, "trajectory", "no poses", "at least one");
  }
  apply(command.edits, file);
  ViewSession session(globals, std::move(file));
  ViewServer server(session, command.server);
  std::cout << server.url() << std::endl;  // at once: somebody waits for it
  server.wait();
}

}  // namespace

void add_view(Command app, const Globals& globals) {
  const auto command = std::make_shared<ViewCommand>();
  Command sub = app.command("view", "a scene in the browser, rendered live, until Ctrl-C");
  sub.option("SCENE", command->scene, "scene folder, or splats: .ply, .spz").required();
  sub.option("--port", command->server.port, "0: any free one").range(0, 65535).with_default();
  sub.option("--host", command->server.host, "address to listen on; others than loopback need --token")
      .with_default();
  sub.option("--token", command->server.token, "a secret that pages must know");
  add_edit_options(sub, command->edits);
  sub.run([command, &globals] { view(*command, globals); });
}

}  // namespace simuli::cli
