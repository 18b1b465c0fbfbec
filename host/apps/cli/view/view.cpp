// Command simuli view: a scene or a log in the browser.
#include <cstdlib>
#include <iostream>
#include <memory>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/view/log_session.hpp"
#include "host/apps/cli/view/view_server.hpp"
#include "host/apps/cli/view/view_session.hpp"
#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {
namespace {

struct ViewCommand {
  std::string scene;
  Edits edits;
  ServerOptions server;
  std::string token_file;
};

/// Returns the token from the command line, a file or the environment; empty: none.
std::string token_of(const ViewCommand& command) {
  if (!command.server.token.empty()) return command.server.token;
  if (command.token_file.empty()) {
    const char* const token = std::getenv("SIMULI_VIEW_TOKEN");
    return token == nullptr ? "" : token;
  }
  constexpr std::size_t kLongest = 4096;
  const std::string text = read_file(command.token_file, kLongest);
  const std::string token = text.substr(0, text.find_first_of("\r\n"));
  if (token.empty()) throw_input_error(command.token_file, "token", "an empty line", "a secret");
  return token;
}

void serve(const ViewCommand& command, ViewAnswers& answers) {
  ServerOptions options = command.server;
  options.token = token_of(command);
  ViewServer server(answers, options);
  std::cout << server.url() << std::endl;  // flushed, because callers wait for the address
  server.wait();
}

void view_log(const ViewCommand& command) {
  if (!lines_of(command.edits).empty()) {
    throw_usage_error("view", "edits of " + command.scene + ", a log", "none; edits of a trained scene");
  }
  LogSession session(read_log(command.scene));
  serve(command, session);
}

void view(const ViewCommand& command, const Globals& globals) {
  if (is_there(std::filesystem::path(command.scene) / "log.json")) return view_log(command);
  SceneFile file = read_scene_and_report(command.scene);
  if (file.world_from_rig.poses().empty()) {
    throw_input_error(command.scene, "trajectory", "no poses", "at least one");
  }
  apply(command.edits, file);
  ViewSession session(globals, std::move(file), {command.scene, command.edits});
  serve(command, session);
}

}  // namespace

void add_view(Command app, const Globals& globals) {
  const auto command = std::make_shared<ViewCommand>();
  Command sub = app.command(
      "view", "show a scene in the browser, rendered on request, or a log before training, until Ctrl-C");
  sub.option("SCENE", command->scene, "scene folder, splats: .ply, .spz, .glb; or log folder").required();
  sub.option("--port", command->server.port, "0: any free one").range(0, 65535).with_default();
  sub.option("--host", command->server.host, "address to listen on; others than loopback need --token")
      .with_default();
  sub.option("--token",
             command->server.token,
             "a secret that pages must send; a file or variable keeps it out of the list of processes: "
             "$SIMULI_VIEW_TOKEN, --token-file");
  sub.option("--token-file", command->token_file, "a file whose first line is the token").excludes("--token");
  add_edit_options(sub, command->edits);
  sub.run([command, &globals] { view(*command, globals); });
}

}  // namespace simuli::cli
