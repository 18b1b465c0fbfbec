#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "host/base/error.hpp"
#include "host/cli/base/commands.hpp"
#include "host/cli/base/json_text.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli::cli {
namespace {

struct ConvertCommand {
  std::string input;
  std::string output;
  bool lidar = false;
};

/// The particles that stand still: those of actors are in their own frames, which no splat file knows.
GaussianSet background(const GaussianSet& set) {
  if (set.actor.empty()) return set;
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < set.actor.size(); ++i) {
    if (set.actor[i] == 0) rows.push_back(static_cast<Eigen::Index>(i));
  }
  GaussianSet out(set.kind, set.sh_degree, static_cast<Eigen::Index>(rows.size()));
  out.params = set.params(rows, Eigen::all);
  return out;
}

GaussianSet read_input(const ConvertCommand& command) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(command.input, ignored)) {
    return command.lidar ? read_gaussians_ply(command.input, SetKind::kLidar) : read_splats(command.input);
  }
  SceneFile file = read_scene(command.input);
  return command.lidar ? std::move(file.scene.lidar) : std::move(file.scene.camera);
}

void convert(const ConvertCommand& command, const Globals& globals) {
  const GaussianSet all = read_input(command);
  const GaussianSet set = background(all);
  write_splats(command.output, set);
  if (set.size() < all.size()) {
    std::cerr << fmt::format("simuli: note: {} particles of actors are left out\n", all.size() - set.size());
  }
  if (globals.json) {
    const nlohmann::ordered_json out = {
        {"file", command.output}, {"particles", set.size()}, {"sh_degree", set.sh_degree}};
    std::cout << json_text(out) << '\n';
  } else {
    std::cout << fmt::format(
        "{} particles of SH degree {} in {}\n", set.size(), set.sh_degree, command.output);
  }
}

}  // namespace

void add_convert(Command app, const Globals& globals) {
  const auto command = std::make_shared<ConvertCommand>();
  Command sub = app.command("convert", "the particles of a scene or a splat file as another file");
  sub.option("INPUT", command->input, "scene folder, .ply (also SuperSplat's compressed) or .spz")
      .required()
      .reads();
  sub.option("-o,--output", command->output, ".ply or .spz to write").required().makes();
  sub.flag("--lidar", command->lidar, "the LiDAR set instead of the camera set; .ply alone");
  sub.run([command, &globals] { convert(*command, globals); });
}

}  // namespace simuli::cli
