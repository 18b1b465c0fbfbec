// Command simuli demo: log, training, evaluation and pictures of the embedded street.
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <optional>
#include <unistd.h>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/file_progress.hpp"
#include "host/apps/cli/base/quoted.hpp"
#include "host/apps/cli/draw/pictures.hpp"
#include "host/apps/cli/report/report.hpp"
#include "host/apps/cli/report/report_parts.hpp"
#include "host/apps/cli/report/training.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "io/base/file.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/synth/street.hpp"
#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

// Size of the pictures: readable, and two cores train in less than a minute.
constexpr int kWidth_px = 640, kHeight_px = 360;

struct DemoCommand {
  std::string output;  // empty: a new temporary folder
  int iterations = 300;
  FrameSelection frames{.image_scale = 1.0};
};

void demo(const DemoCommand& command, const Globals& globals) {
  const Device device = Device::best(globals.device);
  const fs::path output = command.output.empty()
                              ? fs::temp_directory_path() / fmt::format("simuli-demo-{}", ::getpid())
                              : fs::path(command.output);
  TrainingOptions options;
  options.train.render = training_options_of(globals.quality);
  options.train.iterations = command.iterations;
  options.frames = command.frames;
  const TrainingOptions allowed = checked(options);  // fails before any output
  // Writes all outputs or none.
  std::optional<EvalReport> report;
  SceneFile scene;
  write_folder_atomically(output, [&](const fs::path& folder) {
    StreetOptions street;
    street.output = folder / "street.log";
    street.image_width = kWidth_px;
    street.image_height = kHeight_px;
    FileProgress synthesis("synth street", globals);
    const Log log = synth_street(street, synthesis.callback());
    synthesis.finish();

    Training training(device, log, allowed);
    const TrainHistory history = run_training(training, device, globals);
    const TrainedReport trained{training.report(), history};
    scene = trained_scene(std::move(training), globals);
    write_scene(folder / "street.scene", scene);
    Evaluation evaluation(device, scene, log, {.render = options_of(globals.quality)});
    report = run_evaluation(evaluation, globals, folder / "street.scene");
    const PicturePair picture = evaluation.picture(evaluation.frames().images.front());
    write_image(folder / "camera.png", joined(picture.rendered, picture.recorded, Layout::kBeside));
    const std::size_t index = evaluation.frames().sweeps.front();
    const PicturePair ranges =
        range_pictures(evaluation.log().lidar(log.sweeps[index].lidar).model, evaluation.sweep(index));
    write_image(folder / "lidar_range.png", joined(ranges.rendered, ranges.recorded, Layout::kBelow));
    write_report(folder / "report.html",
                 {.title = "simuli demo: the embedded street", .trained = &trained},
                 globals,
                 evaluation,
                 *report);
  });
  print_eval(*report, scene, globals.json);
  if (globals.json) return;
  const auto path_of = [&](const char* name) { return on_one_line((output / name).string()); };
  std::cout << fmt::format("log                             {}\n", path_of("street.log"))
            << fmt::format("scene                           {}\n", path_of("street.scene"))
            << fmt::format("report                          {}\n", path_of("report.html"))
            << fmt::format("held-out picture, rendered | recorded         {}\n", path_of("camera.png"))
            << fmt::format("held-out ranges, rendered above recorded     {}\n", path_of("lidar_range.png"))
            << fmt::format("view                            simuli view {}\n",
                           shell_word((output / "street.scene").string()));
}

}  // namespace

void add_demo(Command app, const Globals& globals) {
  const auto command = std::make_shared<DemoCommand>();
  Command sub = app.command("demo", "run the complete system on an embedded street, in two minutes");
  sub.option("-o,--output", command->output, "folder to write; default: a new temporary folder");
  sub.option("--iterations", command->iterations, "training iterations").with_default();
  sub.option("--held-out-middle",
             command->frames.held_out_middle,
             "also hold out this share of the trajectory around its middle")
      .with_default();
  sub.option("--held-out-last",
             command->frames.held_out_last,
             "also hold out this share of the trajectory at its end")
      .with_default();
  sub.run([command, &globals] { demo(*command, globals); });
}

}  // namespace simuli::cli
