// Command line of simuli-bench: measurements whose results the README quotes.
#include "bench/program/bench.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <memory>
#include <utility>
#include <vector>

#include "bench/drives/drives.hpp"
#include "bench/paper/actors.hpp"
#include "bench/paper/figure10.hpp"
#include "bench/paper/figure11.hpp"
#include "bench/paper/shift.hpp"
#include "bench/paper/table5.hpp"
#include "bench/paper/table8.hpp"
#include "bench/paper/training.hpp"
#include "bench/peers/peers.hpp"
#include "bench/program/report.hpp"
#include "bench/render/agreement.hpp"
#include "bench/render/long_street.hpp"
#include "bench/render/sensor_errors.hpp"
#include "bench/render/stages.hpp"
#include "bench/render/table7.hpp"
#include "bench/trade/plan.hpp"
#include "bench/trade/trade.hpp"
#include "host/apps/cli/base/program.hpp"
#include "host/apps/cli/base/settings.hpp"
#include "host/apps/cli/draw/pictures.hpp"
#include "host/core/base/error.hpp"
#include "host/device/render/options/quality.hpp"
#include "host/device/render/options/validate.hpp"
#include "io/picture/image.hpp"

namespace simuli::bench {
namespace {

using cli::Command;
using cli::Globals;
using cli::Option;

struct BenchCommand {
  bool stages = false;
  bool extremes = false;
  bool training = false;
  bool actors = false;
  bool plan = false;
  bool trade = false;
  bool peers = false;
  bool shift = false;
  std::vector<std::string> settings;  // measured by the trade-off in addition to the qualities
  std::string picture;                // file for pictures of the shifted rig
  std::string report;                 // HTML file to write; empty: none
  int table = 0;                      // table of the paper; 0: none
  int figure = 0;                     // figure of the paper; 0: none
  std::string agreement;              // results of another implementation; empty: none
  std::string log;                    // drive for tables and figures; empty: the embedded street
  int iterations = 0;                 // 0: default of each bench
  StagesOptions stage_options;
  LongStreetOptions long_street;
  Table5Options table5;
  Table8Options table8;
  Figure10Options figure10;
  Figure11Options figure11;
  ActorsOptions actor_options;
  TradeOptions trade_options;
  PeersOptions peer_options;
  DrivesOptions drives;
  ShiftOptions shift_options;
};

void run_drives(const BenchCommand& command, const Globals& globals, const Note& note) {
  DrivesOptions options = command.drives;
  options.settings = command.settings;
  const std::vector<DriveRow> rows = run_drives(globals.device, options, note);
  std::cout << (globals.json ? to_json(rows) : to_markdown(rows));
}

void run_trade(const BenchCommand& command, const Globals& globals, const Note& note) {
  TradeOptions options = command.trade_options;
  if (!command.settings.empty()) {
    options.own_name = fmt::format("{}", fmt::join(command.settings, " "));
    options.own = options_of(globals.quality);
    fields_of(options.own).apply(command.settings);
    validate(options.own);
  }
  const std::vector<TradePoint> points = run_trade(globals.device, options, note);
  if (!command.report.empty()) {
    write_report(command.report, "simuli bench --trade", trade_rows(points), front_charts(points));
  }
  std::cout << (globals.json ? to_json(trade_rows(points)) : trade_table(points));
}

void run_peers(const BenchCommand& command, const Globals& globals, const Note& note) {
  const std::vector<PeerCase> cases = run_peers(globals.device, command.peer_options, note);
  if (!command.report.empty()) write_report(command.report, "simuli bench --peers", peer_rows(cases));
  std::cout << (globals.json ? to_json(peer_rows(cases)) : peer_table(cases));
}

/// Returns one row per pair: rendered, then ground truth.
Image picture_of(const std::vector<ShiftResult::Pair>& pairs) {
  Image all;
  for (const ShiftResult::Pair& pair : pairs) {
    const Image row = cli::joined(pair.rendered, pair.truth, cli::Layout::kBeside);
    all = all.height == 0 ? row : cli::joined(all, row, cli::Layout::kBelow);
  }
  return all;
}

std::vector<Row> run_shift(const BenchCommand& command, const Globals& globals, const Note& note) {
  ShiftOptions options = command.shift_options;
  options.settings = command.settings;
  ShiftResult result = run_shift(globals.device, options, note);
  if (!command.picture.empty()) write_image(command.picture, picture_of(result.pictures));
  return std::move(result.rows);
}

void measure(BenchCommand command, const Globals& globals) {
  const std::array requested{command.stages,
                             command.extremes,
                             command.training,
                             command.actors,
                             command.plan,
                             command.trade,
                             command.peers,
                             command.shift,
                             !command.drives.drives.empty(),
                             !command.agreement.empty(),
                             command.long_street.length_m > 0.0,
                             command.table != 0,
                             command.figure != 0};
  const auto count = std::count(requested.begin(), requested.end(), true);
  if (count != 1) {
    throw Error(ErrorKind::kUsage,
                fmt::format("bench: found {} tables, allowed one of --stages, --training, --extremes, "
                            "--drive, --actors, --plan, --trade, --peers, --shift, --agreement, "
                            "--long-street, --table 5|7|8, --figure 10|11",
                            count));
  }
  if (!command.log.empty() && command.table != 5 && command.table != 8 && command.figure != 11) {
    throw Error(ErrorKind::kUsage, "bench: --log: found without --table 5|8, --figure 11, allowed with one");
  }
  if (command.shift_options.detailed && !command.shift) {
    throw Error(ErrorKind::kUsage, "bench: --detailed: found without --shift, allowed with it");
  }
  const DrivesOptions& drives = command.drives;
  if (drives.drives.empty() && (!drives.lengths.empty() || !drives.keep.empty() || drives.time_to_db > 0.0)) {
    throw Error(ErrorKind::kUsage,
                "bench: --lengths, --time-to, --keep: found without --drive, allowed with it");
  }
  command.table5.log = command.table8.log = command.figure11.log = command.log;
  if (command.iterations > 0) {
    if (command.table != 5 && command.table != 8 && command.figure == 0 && !command.actors &&
        !command.shift) {
      throw Error(
          ErrorKind::kUsage,
          "bench: --iterations: found without a training, allowed with --table 5|8, --figure, --actors, "
          "--shift");
    }
    command.table5.iterations = command.table8.iterations = command.figure10.iterations =
        command.figure11.iterations = command.actor_options.iterations = command.shift_options.iterations =
            command.iterations;
  }
  const auto note = [](const std::string& line) { std::cerr << line << '\n'; };
  std::vector<Row> rows;
  std::vector<std::string> broken;
  if (command.stages) rows = run_stages(globals.device, command.stage_options, note);
  if (command.long_street.length_m > 0.0) {
    command.long_street.particles = command.stage_options.particles;
    command.long_street.frames = command.stage_options.frames;
    rows = run_long_street(globals.device, command.long_street, note);
  }
  if (command.training) rows = run_training(globals.device, {}, note);
  if (command.table == 5) rows = run_table5(globals.device, command.table5, note);
  if (command.table == 7) rows = run_table7(globals.device, command.stage_options.particles, note);
  if (command.table == 8) rows = run_table8(globals.device, command.table8, note);
  if (command.figure == 10) rows = run_figure10(globals.device, command.figure10, note);
  if (command.figure == 11) rows = run_figure11(globals.device, command.figure11, note);
  if (!command.agreement.empty()) rows = run_agreement(globals.device, command.agreement, note);
  if (command.actors) rows = run_actors(globals.device, command.actor_options, note);
  if (command.plan) {
    rows = run_plan(globals.device, {command.stage_options.particles, command.stage_options.frames}, note);
  }
  if (command.trade) return run_trade(command, globals, note);
  if (command.shift) rows = run_shift(command, globals, note);
  if (command.peers) return run_peers(command, globals, note);
  if (!command.drives.drives.empty()) return run_drives(command, globals, note);
  if (command.extremes) {
    ExtremesReport report = run_extremes(globals.device, note);
    rows = std::move(report.rows);
    broken = std::move(report.broken);
  }
  if (!command.report.empty()) write_report(command.report, "simuli bench", rows);
  std::cout << (globals.json ? to_json(rows) : to_text(rows));
  if (broken.empty()) return;
  for (const std::string& line : broken) note(line);
  throw Error(ErrorKind::kNumeric, fmt::format("bench --extremes: {} bounds broken", broken.size()));
}

void add_drives(const Command& command, BenchCommand& options) {
  command.option(
      "--drive",
      options.drives.drives,
      "the README's table: trains on each drive with defaults alone and compares; street, log folders as "
      "DIR, folders of KITTI raw as DIR[,poses=FILE][,labels=FILE]; settings of a DIR's own as ,KEY=VALUE");
  command.option(
      "--lengths", options.drives.lengths, "--drive: iterations, ascending; a training and a row for each");
  command
      .option("--time-to",
              options.drives.time_to_db,
              "--drive: held-out dB at which longer trainings end; without --lengths 100, 200, ... 3200 "
              "iterations")
      .range(1.0, 100.0);
  command.option("--keep",
                 options.drives.keep,
                 "--drive: folder of rows, scenes and checkpoints; what is there is not made again");
}

void add_bench(const Command& command, const Globals& globals) {
  const auto options = std::make_shared<BenchCommand>();
  command.flag("--stages", options->stages, "each stage of a camera and a LiDAR frame, forward and backward");
  command.flag(
      "--extremes", options->extremes, "float against double at the ends of range, size and position");
  command.flag("--training",
               options->training,
               "an iteration of training by stage, anchoring, memory; 50 k, 200 k and 1 M particles");
  command.flag("--actors",
               options->actors,
               "the street's moving car: with actors, without, edited, with a noisy track");
  add_drives(command, *options);
  command
      .option("--table",
              options->table,
              "5: factorised sets against one; 7: ray-based culling; 8: unscented, "
              "linearised and Monte Carlo projection")
      .one_of({5, 7, 8});
  command
      .option("--figure",
              options->figure,
              "10: thin poles and the footprint filter; 11: motion during a frame, modelled and ignored")
      .one_of({10, 11});
  command.option(
      "--log", options->log, "tables 5 and 8, figure 11: a drive, as --drive has it, instead of the street");
  command.option("--iterations", options->iterations, "of each training of a table or figure")
      .range(1, 1'000'000);
  const Option particles =
      command.option("--particles", options->stage_options.particles, "Gaussians of the synthetic street")
          .range(std::int64_t{1}, std::int64_t{16'000'000})
          .with_default();
  const Option frames =
      command.option("--frames", options->stage_options.frames, "frames timed; the median is told")
          .range(5, 10'000)
          .with_default();
  command.flag("--plan",
               options->plan,
               "each optional part of a frame present, absent, and never mentioned: time and memory");
  command.flag("--trade",
               options->trade,
               "speed against accuracy: every option alone and the qualities, against the reference");
  command.flag("--peers",
               options->peers,
               "the same particles ray traced with Embree, in turns with ours; 50 k, 200 k and 1 M");
  command.flag("--shift",
               options->shift,
               "the street's scene beside the truth off the recorded path: moved, higher, turned, with other "
               "sensors");
  command.flag("--detailed",
               options->shift_options.detailed,
               "--shift: on a richer street: leaves, railings, kerbs, shops, vans, worn markings");
  command.option("--agreement",
                 options->agreement,
                 "every ray of a camera and a LiDAR frame against FILE, which another OpenCL "
                 "implementation wrote this way; written when it is not there");
  command
      .option("FOLDERS",
              options->trade_options.folders,
              "--trade: a scene, and the log of its frames; default: the bench street")
      .values(0, 2);
  command
      .option(
          "--long-street",
          options->long_street.length_m,
          "frames along a street of so many metres, with particles in clusters that are left out and without")
      .range(10.0, 10'000.0);
  command.option(
      "--report", options->report, "HTML file to write: the rows, a table for each thing measured");
  command.option("--picture", options->picture, "--shift: a PNG of renders beside the truth");
  const auto fields = [options, &globals] {
    options->trade_options.own = options_of(globals.quality);
    return fields_of(options->trade_options.own);
  };
  cli::add_settings(
      command,
      options->settings,
      globals,
      fields,
      "--trade: KEY=VALUE..., only these together, and the qualities; help: lists the keys; --drive: and "
      "--shift: keys of simuli train, for all trainings");
  command.option("--repeats", options->trade_options.repeats, "--trade: timed renders of each view")
      .range(1, 1000)
      .with_default();
  command.option("--sensor", options->trade_options.sensor, "--trade: only this sensor");
  command.option("--scale", options->trade_options.image_scale, "--trade: size of the scene's pictures")
      .with_default();
  command.run([options, particles, frames, &globals] {
    // Peers use their own numbers unless a number is given.
    if (particles.is_given()) options->peer_options.particles = {options->stage_options.particles};
    if (frames.is_given()) options->peer_options.frames = options->stage_options.frames;
    measure(*options, globals);
  });
}

}  // namespace

int run_bench(int argc, char** argv) {
  return cli::run_program(
      "simuli bench",
      "measure: times, and the numbers of the paper's tables",
      argc,
      argv,
      [](cli::CommandLine& line, const Globals& globals) { add_bench(line.root(), globals); });
}

}  // namespace simuli::bench
