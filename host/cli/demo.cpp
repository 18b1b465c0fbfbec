// The whole system on the embedded street: log, training, evaluation, pictures.
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <optional>
#include <unistd.h>

#include "host/base/error.hpp"
#include "host/cli/commands.hpp"
#include "host/cli/file_progress.hpp"
#include "host/cli/pictures.hpp"
#include "host/cli/training.hpp"
#include "host/render/look.hpp"
#include "io/file.hpp"
#include "io/scene_folder.hpp"
#include "io/street.hpp"
#include "optim/frames.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

struct DemoCommand {
  std::string output;  // empty: a new folder below the temporary one
  int iterations = 400;
};

/// A held-out picture as rendered, beside the recorded one.
void write_camera_pair(Renderer& renderer, const Log& log, const Scene& scene, const fs::path& file) {
  const std::size_t index = select_frames(log.images, EvalOptions{}.held_out_every, true).front();
  const ImageFrame& frame = log.images[index];
  const Camera& camera = log.camera(frame.camera).model;
  const ParticleBuffers particles(renderer.device(), scene.camera, renderer.options().precision);
  const SensorRays rays(renderer.device(), camera, renderer.options());
  SceneLook(renderer.device(), scene, renderer.options().precision)
      .render(renderer,
              particles,
              rays,
              view_of(log, scene, frame),
              frame.camera,
              0.5 * (frame.time_start_s + frame.time_end_s));
  write_image(
      file, joined(picture_of(renderer.results(), camera), load_image(log, frame, camera), Layout::kBeside));
}

/// A held-out sweep's ranges as rendered, over the recorded ones.
void write_lidar_pair(Renderer& renderer, const Log& log, const Scene& scene, const fs::path& file) {
  const std::size_t index = select_frames(log.sweeps, EvalOptions{}.held_out_every, true).front();
  const SweepFrame& frame = log.sweeps[index];
  const LidarModel& lidar = log.lidar(frame.lidar).model;
  const ParticleBuffers particles(renderer.device(), scene.lidar, renderer.options().precision);
  const SweepPair pair = render_sweep(renderer, particles, log, scene, frame);
  write_image(
      file,
      joined(range_image(
                 lidar, pair.recorded.rays, lidar_picture(lidar, pair.recorded.rays, pair.simulated).range),
             range_image(lidar, pair.recorded.rays, pair.recorded.range),
             Layout::kBelow));
}

void demo(const DemoCommand& command, const Globals& globals) {
  const Device device = Device::best(globals.device);
  const fs::path output = command.output.empty()
                              ? fs::temp_directory_path() / fmt::format("simuli-demo-{}", ::getpid())
                              : fs::path(command.output);
  // All or nothing, like every folder that is written.
  std::optional<EvalReport> report;
  write_folder_atomically(output, [&](const fs::path& folder) {
    StreetOptions street;
    street.output = folder / "street.log";
    FileProgress synthesis("synth street", globals);
    const Log log = synth_street(street, synthesis.callback());
    synthesis.finish();

    InitOptions init;
    TrainOptions train;
    train.iterations = command.iterations;
    train.image_scale = init.image_scale = 1.0;
    const TrainedScene trained = train_scene(device, log, init, train, globals);
    write_scene(folder / "street.scene", trained.file);
    report = evaluate_scene(device, log, trained.file.scene, EvalOptions{}, globals);
    Renderer renderer(device, RenderOptions{});
    write_camera_pair(renderer, log, trained.file.scene, folder / "camera.png");
    write_lidar_pair(renderer, log, trained.file.scene, folder / "lidar_range.png");
  });
  print_eval(*report, globals.json);
  if (globals.json) return;
  std::cout << fmt::format("log                             {}\n", (output / "street.log").string())
            << fmt::format("scene                           {}\n", (output / "street.scene").string())
            << fmt::format("held-out picture, rendered beside recorded   {}\n",
                           (output / "camera.png").string())
            << fmt::format("held-out ranges, rendered over recorded      {}\n",
                           (output / "lidar_range.png").string());
}

}  // namespace

void add_demo(CLI::App& app, const Globals& globals) {
  const auto command = std::make_shared<DemoCommand>();
  CLI::App* sub = app.add_subcommand("demo", "the whole system on an embedded street, in two minutes");
  sub->add_option("-o,--output", command->output, "folder to make; default: a new temporary one");
  sub->add_option("--iterations", command->iterations, "of training")->capture_default_str();
  sub->callback([command, &globals] { demo(*command, globals); });
}

}  // namespace simuli::cli
