#pragma once
// A file of splats (io/splat/splat_file.hpp) as a scene, which it isn't: it tells neither what is up nor how
// large it is, and has no sensors and no path.
#include <filesystem>

#include "host/core/base/pose.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {

/// How a file's axes and unit stand in the world.
struct SplatPlacement {
  SplatAxes axes = SplatAxes::kYDown;
  double metres_per_unit = 1.0;
  Pose world_from_model;  // of the model with z up (and x forward): behind both
};

/// Whether read_scene() takes this path for a file of splats: has_splat_extension(), and no folder.
[[nodiscard]] bool is_splat_file(const std::filesystem::path& file);

/// The particles as camera set, and their geometry as LiDAR set (lidar_of()). A camera "orbit" (1280 x 720
/// px, 60 degrees wide) and a LiDAR "hesai_xt32" in its place go once around what extent_of() the particles
/// says in 10 s, 20 degrees above its middle, with 100 frames each. Error{kInput} for files that can't be
/// read, without particles, or with particles of actors; Error{kUsage} for scales that are not above 0 and
/// finite.
[[nodiscard]] SceneFile scene_of_splats(const std::filesystem::path& file,
                                        const SplatPlacement& placement = {});
/// The same of what a file of that name holds.
[[nodiscard]] SceneFile scene_of_splats(GaussianSet splats,
                                        const std::filesystem::path& file,
                                        const SplatPlacement& placement = {});

}  // namespace simuli
