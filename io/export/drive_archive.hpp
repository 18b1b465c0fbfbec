#pragma once
// A drive for closed-loop simulators: the .usdz that AlpaSim's runtime and CARLA's NuRec client read beside a
// renderer that speaks sensorsim, as `simuli serve` does.
#include <filesystem>
#include <string>

#include "io/scene/scene_folder.hpp"

namespace simuli {

struct DriveArchive {
  std::size_t actors = 0;
  std::size_t ground_triangles = 0;  // 0: the LiDAR set has no ground below the path, and the archive no mesh
  std::size_t cameras_without_model = 0;  // of lenses that the format has no name for
};

/// Writes the archive, complete or not at all: splats.usda (the camera set without actors, z up),
/// metadata.yaml, rig_trajectories.json, sequence_tracks.json, data_info.json, map.xodr (road_map()),
/// mesh_ground.ply and the same as mesh.ply. Places are m from the scene's origin, times SceneClock's, the
/// scene's name is `scene_id`: as the server of the same scene tells them. Error{kInput} for other extensions
/// than .usdz, a scene without a path or without cameras, and more than 4 GiB.
DriveArchive write_drive_archive(const std::filesystem::path& file,
                                 const SceneFile& scene,
                                 const std::string& scene_id);

}  // namespace simuli
