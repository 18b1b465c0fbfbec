#pragma once
// Initialisation of a scene from a log: LiDAR returns become particles, images give them colours, and objects
// beyond the LiDARs' reach (sky, far buildings) become a far shell. METHOD section 12.
#include <cstddef>
#include <functional>

#include "host/core/scene/scene.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/init/init_options.hpp"

namespace simuli {

struct SceneInit {
  Scene scene;
  GaussianSet unmet;  // LiDAR particles added after training, because no training ray hits or supports them
  InitReport report;
};

/// Returns the far shell's distance in m: three times the farthest point's, at least 200.
[[nodiscard]] double shell_distance_m(double farthest_m);

/// Reads the training sweeps and images of `log` selected by `frames`, one at a time, and makes both particle
/// sets of the static background and of the actors (sweeps are read twice to remove moving objects). The camera
/// set suits pictures of that size. The same log and options give the same bits. The scene's origin is the mean
/// position of the trajectory in whole metres. Calls progress(done, total) first and after each file. Throws
/// Error{kUsage} for options outside their range, Error{kInput} when no training frame is left or a file cannot
/// be read.
[[nodiscard]] SceneInit initialize_scene(const Log& log,
                                         const FrameSelection& frames,
                                         const InitOptions& options,
                                         const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli
