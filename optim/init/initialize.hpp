#pragma once
// First guess of a scene from a log: LiDAR returns become particles, images give them colour, and what no
// laser reaches (sky, far buildings) becomes a far shell. METHOD section 12.
#include <cstddef>
#include <functional>

#include "host/core/scene/scene.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/init/init_options.hpp"

namespace simuli {

struct SceneInit {
  Scene scene;
  GaussianSet unmet;  // of the LiDAR set, for when it has been trained: no ray meets it, so none keeps it
  InitReport report;
};

/// m, of the far shell of what lies so far from the scene's origin: three times as much, 200 at least.
[[nodiscard]] double shell_distance_m(double farthest_m);

/// Reads the training sweeps and images of `log` that `frames` selects, one at a time, and builds both
/// particle sets of the static background and of the actors (sweeps are read twice to drop what moved). The
/// camera set is made for pictures of that size. The same log and options give the same bits. The scene's
/// origin is the mean position of the trajectory in whole metres. `progress(done, total)` is called first and after
/// each file. Throws Error{kUsage} for options outside their range, Error{kInput} when no frame is left for
/// training or a file can't be read.
[[nodiscard]] SceneInit initialize_scene(const Log& log,
                                         const FrameSelection& frames,
                                         const InitOptions& options,
                                         const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli
