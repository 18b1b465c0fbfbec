// train LOG SCENE ITERATIONS: a scene from a log as `simuli train` makes it, with progress, and how well it
// shows the frames that it was not trained on.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <simuli/simuli.hpp>

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: train LOG SCENE ITERATIONS\n"), 2;
  try {
    const simuli::Device device = simuli::Device::best();
    const simuli::Log log = simuli::read_log(argv[1]);
    simuli::TrainingOptions options;
    options.train.iterations = std::atoi(argv[3]);
    simuli::Training training(device, log, options);
    training.run([](const simuli::TrainStatus& status) {
      if (status.iteration % 10 == 0) std::printf("%d: %.2f dB\n", status.iteration, status.psnr_db);
    });
    const auto scores =
        simuli::write_trained_scene(argv[2], device, training.result(), log, options.train.render);
    if (scores) {
      const double distance_cm = 100.0 * scores->distance_median_m;
      std::printf("held-out frames: %.2f dB, %.2f cm\n", scores->psnr_db, distance_cm);
    }
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "train: %s\n", error.what()), 1;
  }
  return 0;
}
