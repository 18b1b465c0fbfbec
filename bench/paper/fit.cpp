#include "bench/paper/fit.hpp"

#include <utility>

#include "io/picture/image.hpp"

namespace simuli::bench {

void write_frames(const Log& log, const Street& street) {
  for (const ImageFrame& f : log.images) {
    std::filesystem::create_directories((log.folder / f.file).parent_path());
    write_image(
        log.folder / f.file,
        render_street(street, log.camera(f.camera), log.world_from_rig, f.time_start_s, f.time_end_s));
  }
  for (const SweepFrame& f : log.sweeps) {
    std::filesystem::create_directories((log.folder / f.file).parent_path());
    write_sweep(log.folder / f.file,
                scan_street(street, log.lidar(f.lidar), log.world_from_rig, f.time_start_s, f.time_end_s));
  }
}

SceneFile fit(const Device& device, const Log& log, const TrainingOptions& options) {
  Training training(device, log, options);
  training.run();
  return training.result();
}

EvalReport compare(const Device& device, const Log& log, const SceneFile& scene, EvalOptions options) {
  if (scene.training) {
    options.held_out_every = scene.training->frames.held_out_every;
    options.held_out_middle = scene.training->frames.held_out_middle;
    options.held_out_last = scene.training->frames.held_out_last;
  }
  return Evaluation(device, scene, log, options).run();
}

}  // namespace simuli::bench
