#include <memory>

#include "host/cli/base/commands.hpp"
#include "host/cli/base/file_progress.hpp"
#include "host/cli/info/info.hpp"
#include "io/synth/street.hpp"

namespace simuli::cli {
namespace {

void synth(const StreetOptions& options, const Globals& globals) {
  FileProgress progress("synth street", globals);
  const Log log = synth_street(options, progress.callback());
  progress.finish();
  print_log(log, globals.json);
}

}  // namespace

void add_synth(Command app, const Globals& globals) {
  Command command = app.command("synth", "make a log of an embedded scene, whose truth is known exactly");
  command.require_command();

  const auto options = std::make_shared<StreetOptions>();
  Command street = command.command("street", "a street with one moving car");
  street.option("-o,--output", options->output, "log folder to write").required().makes();
  const auto add = [&](const char* name, auto& value, const char* text) {
    street.option(name, value, text).with_default();
  };
  add("--frames", options->frames, "images per camera and sweeps");
  add("--speed", options->speed_m_per_s, "of the rig, m/s");
  add("--lane-shift", options->lane_shift_m, "so far to its left, m: the truth of `render --lane-shift`");
  add("--image-width", options->image_width, "pixels");
  add("--image-height", options->image_height, "pixels");
  add("--lidar-columns", options->lidar_columns, "firings per turn");
  add("--seed", options->seed, "of textures and furniture");
  street.flag("--moving-car,!--no-moving-car", options->moving_car, "one car drives; default: yes");
  street.flag("--rolling-shutter", options->rolling_shutter, "20 ms top to bottom instead of global");
  street.run([options, &globals] { synth(*options, globals); });
}

}  // namespace simuli::cli
