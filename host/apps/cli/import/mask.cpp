// Command simuli mask: adds ego masks to the cameras of a log.
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/one_line.hpp"
#include "io/base/output.hpp"
#include "io/log/camera_mask.hpp"
#include "io/log/log.hpp"
#include "io/log/log_json.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

struct MaskCommand {
  std::string log, output;
  std::vector<std::string> masks;  // CAMERA:FILE
};

/// Adds the mask CAMERA:FILE to the log, and its file to `files` by name in the log.
void put_mask(Log& log, const std::string& given, std::map<std::string, fs::path>& files) {
  const std::size_t colon = given.find(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == given.size())
    throw_usage_error("CAMERA:FILE", given, "front:mask.png");
  const std::string camera = given.substr(0, colon);
  const fs::path file = given.substr(colon + 1);
  (void)read_camera_mask(file, log.camera(camera).model);
  need_name(file.filename().string(), given, "name of the file");
  const std::string name = fmt::format("masks/{}/{}", camera, file.filename().string());
  const bool is_there =
      std::any_of(log.masks.begin(), log.masks.end(), [&](const LogMask& mask) { return mask.file == name; });
  if (is_there) throw_input_error(log.folder.string(), "masks", name + ", already", "a file of another name");
  log.masks.push_back({camera, name});
  files[name] = file;
}

void mask(const MaskCommand& command, const Globals& globals) {
  need_new_path(command.output);
  Log log = read_log(command.log);
  std::map<std::string, fs::path> files;
  for (const std::string& given : command.masks) put_mask(log, given, files);
  const Log written = copy_log(log, command.output, files);
  if (globals.json) {
    Json cameras = Json::array();
    for (const auto& [camera, hidden] : written.hidden)
      cameras.push_back({{"camera", camera}, {"hidden_share", hidden->hidden_share()}});
    std::cout << json_text(Json{{"log", command.output}, {"cameras", std::move(cameras)}}) << '\n';
    return;
  }
  for (const auto& [camera, hidden] : written.hidden)
    std::cout << fmt::format(
        "  {}: {:.1f} % of its pictures hidden\n", camera, 100.0 * hidden->hidden_share());
  std::cout << fmt::format("log {} written\n", on_one_line(command.output));
}

}  // namespace

void add_mask(Command app, const Globals& globals) {
  const auto command = std::make_shared<MaskCommand>();
  Command sub = app.command("mask", "mask the ego vehicle in the pictures of a log, for training and scores");
  sub.option("LOG", command->log, "log folder").required();
  sub.option("MASK",
             command->masks,
             "CAMERA:FILE, a picture of the camera's size: pixels other than 0 are hidden. A camera may have "
             "several masks")
      .required();
  sub.option("-o,--output", command->output, "log folder to write; it shares pictures and sweeps with LOG")
      .required();
  sub.run([command, &globals] { mask(*command, globals); });
}

}  // namespace simuli::cli
