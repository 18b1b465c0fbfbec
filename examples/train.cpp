// train LOG SCENE ITERATIONS: a scene from a log, with progress.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <simuli/simuli.hpp>
#include <utility>

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: train LOG SCENE ITERATIONS\n"), 2;
  try {
    const simuli::Log log = simuli::read_log(argv[1]);
    simuli::SceneInit start = simuli::initialize_scene(log, simuli::InitOptions{});
    simuli::TrainOptions options;
    options.iterations = std::atoi(argv[3]);
    simuli::Trainer trainer(
        simuli::Device::best(), log, std::move(start.scene), options, std::move(start.moving));
    trainer.run([](const simuli::TrainStatus& status) {
      if (status.iteration % 10 == 0) std::printf("%d: %.2f dB\n", status.iteration, status.psnr_db);
    });
    simuli::write_scene(argv[2], {trainer.scene(), log.cameras, log.lidars, log.world_from_rig});
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "train: %s\n", error.what()), 1;
  }
  return 0;
}
