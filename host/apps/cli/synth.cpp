#include <fmt/format.h>
#include <memory>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/file_progress.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/info/info.hpp"
#include "host/core/base/error.hpp"
#include "io/synth/long_street.hpp"
#include "io/synth/street.hpp"

namespace simuli::cli {
namespace {

struct SynthCommand {
  StreetOptions street;
  double length_m = 0.0;
  int cameras = LongStreetOptions().cameras;
  int lidars = LongStreetOptions().lidars;
};

LongStreetOptions long_options(const SynthCommand& command) {
  const StreetOptions& s = command.street;
  return {.output = s.output,
          .length_m = command.length_m,
          .frames = s.frames,
          .cameras = command.cameras,
          .lidars = command.lidars,
          .lane_shift_m = s.lane_shift_m,
          .image_width = s.image_width,
          .image_height = s.image_height,
          .lidar_columns = s.lidar_columns,
          .traffic = s.moving_car,
          .rolling_shutter = s.rolling_shutter,
          .seed = s.seed};
}

void synth(const SynthCommand& command, bool is_long, const Globals& globals) {
  FileProgress progress("synth street", globals);
  const Log log = is_long ? synth_long_street(long_options(command), progress.callback())
                          : synth_street(command.street, progress.callback());
  progress.finish();
  print_log(log, globals.json);
}

/// Throws Error{kUsage} if the option was given for the short street.
void need_long(const Option& option, const char* name) {
  if (!option.is_given()) return;
  throw_usage_error(name, "without --length", "only with --length");
}

}  // namespace

void add_synth(Command app, const Globals& globals) {
  Command command = app.command("synth", "make a log of an embedded scene with known ground truth");
  command.require_command();

  const auto all = std::make_shared<SynthCommand>();
  StreetOptions* const options = &all->street;
  Command street = command.command("street", "a street with one moving car");
  street.option("-o,--output", options->output, "log folder to write").required();
  const auto add = [&](const char* name, auto& value, const char* text) {
    return street.option(name, value, text).with_default();
  };
  add("--frames", options->frames, "images per camera and sweeps");
  add("--speed", options->speed_m_per_s, "speed of the rig, m/s; not with --length");
  Option length = street.option(
      "--length",
      all->length_m,
      "length in m of a long street with bends, hills, crossings and traffic; the frames cover it "
      "at the speed that this needs");
  length.excludes("--speed");
  const Option cameras =
      add("--cameras", all->cameras, "number of cameras of the long street's rig: front, left, right, rear");
  const Option lidars =
      add("--lidars", all->lidars, "number of LiDARs of the long street's rig: top, front_low, rear_low");
  add("--lane-shift",
      options->lane_shift_m,
      "shift of the rig to the left, m: ground truth for `render --lane-shift`");
  add("--image-width", options->image_width, "pixels");
  add("--image-height", options->image_height, "pixels");
  add("--lidar-columns", options->lidar_columns, "columns per revolution");
  add("--seed", options->seed, "seed of textures and street furniture");
  street.flag("--moving-car,!--no-moving-car", options->moving_car, "add moving cars; default: yes");
  street.flag(
      "--walker", options->walking_person, "add a pedestrian who crosses the street; not with --length");
  length.excludes("--walker");
  street.flag("--rolling-shutter",
              options->rolling_shutter,
              "rolling shutter of 20 ms from top to bottom instead of a global shutter");
  street.run([all, length, cameras, lidars, &globals] {
    const bool is_long = length.is_given();
    if (!is_long) need_long(cameras, "--cameras");
    if (!is_long) need_long(lidars, "--lidars");
    synth(*all, is_long, globals);
  });
}

}  // namespace simuli::cli
