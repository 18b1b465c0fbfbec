#pragma once
// A drive for closed-loop simulators: the .usdz that AlpaSim's runtime and CARLA's NuRec client read in
// addition to a sensorsim renderer such as `simuli serve`.
#include <filesystem>
#include <string>

#include "io/scene/scene_folder.hpp"

namespace simuli {

struct DriveArchive {
  std::size_t actors = 0;
  // 0: the LiDAR set has no ground below the trajectory, and the archive has no mesh
  std::size_t ground_triangles = 0;
  std::size_t cameras_without_model = 0;  // with lenses that the format does not support
};

/// Writes the archive atomically: splats.usda (the camera set without actors, z up), metadata.yaml,
/// rig_trajectories.json, sequence_tracks.json, data_info.json, map.xodr (road_map()), and mesh_ground.ply,
/// also as mesh.ply. Coordinates are metres from the scene's origin, times are SceneClock's, and the scene's
/// name is `scene_id`, as in the server of the same scene. Throws Error{kInput} for other extensions than
/// .usdz, a scene without a trajectory or cameras, and more than 4 GiB.
DriveArchive write_drive_archive(const std::filesystem::path& file,
                                 const SceneFile& scene,
                                 const std::string& scene_id);

}  // namespace simuli
