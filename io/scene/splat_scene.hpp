#pragma once
// A splat file (io/splat/splat_file.hpp) as a scene. Such files specify neither an up direction nor a unit, and
// have no sensors and no trajectory.
#include <filesystem>

#include "host/core/base/pose.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {

/// Orientation and scale of a file's model in the world.
struct SplatPlacement {
  SplatAxes axes = SplatAxes::kYDown;
  double metres_per_unit = 1.0;
  Pose world_from_model;  // of the model with z up (and x forward); applied last
};

/// Whether read_scene() treats this path as a splat file: has_splat_extension() and not a folder.
[[nodiscard]] bool is_splat_file(const std::filesystem::path& file);

/// Returns a scene with the particles as camera set and their geometry as LiDAR set (lidar_of()). A camera
/// "orbit" (1280 x 720 px, 60 degrees wide) and a LiDAR "hesai_xt32" orbit the box of extent_of() once in 10 s,
/// 20 degrees above its centre, with 100 frames each. Throws Error{kInput} for files that are unreadable, empty
/// or contain particles of actors; Error{kUsage} for scales that are not positive and finite.
[[nodiscard]] SceneFile scene_of_splats(const std::filesystem::path& file,
                                        const SplatPlacement& placement = {});
/// The same for the content of a file.
[[nodiscard]] SceneFile scene_of_splats(GaussianSet splats,
                                        const std::filesystem::path& file,
                                        const SplatPlacement& placement = {});

}  // namespace simuli
