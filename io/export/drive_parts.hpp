#pragma once
// Parts of a drive archive (io/export/drive_archive.hpp).
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/ground/ground_map.hpp"
#include "io/base/json_reader.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_clock.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// Returns AlpaSim's rig_trajectories.json: the trajectory in metres from the scene's origin, the cameras and
/// the exposure times of their pictures. An instant lasts a microsecond, because ends must be after starts.
[[nodiscard]] Json rig_trajectories(const SceneFile& scene,
                                    const SceneClock& clock,
                                    const std::string& sequence);

/// Returns the rig's poses in time order, in metres from the scene's origin.
[[nodiscard]] std::vector<Pose> local_path(const SceneFile& scene);

/// Returns AlpaSim's sequence_tracks.json: actors' boxes and the poses of their centres in metres from the
/// scene's origin, xyz and quaternion xyzw. An actor with one pose is static while it is present; one with more
/// is DYNAMIC, because CARLA's client moves no others. Kinds are those of label_class_of().
[[nodiscard]] Json sequence_tracks(const Scene& scene, const SceneClock& clock);

/// Returns an ASAM OpenDRIVE 1.4 file with one road along the driven trajectory (not a survey). Coordinates are
/// metres in the frame of `rig` (at least one pose, in time order, z up) and `ground`; without a geoReference,
/// because the position on Earth is unknown. Lanes are kLaneWidth_m wide: the right one is centred on the
/// trajectory, the left one beside it is for oncoming traffic. Its height is the ground's below the trajectory;
/// where the ground is unknown, the rig's height minus its usual height above the ground; without any ground,
/// the rig's own height.
[[nodiscard]] std::string road_map(const std::vector<Pose>& rig, const GroundMap& ground);

inline constexpr double kLaneWidth_m = 3.5;

/// Returns a binary little-endian PLY: floats x, y, z and faces of three vertex_indices.
[[nodiscard]] std::string ply_of(const TriangleMesh& mesh);

/// Returns {"type", "parameters"} in the format of NVIDIA's programs; null for lenses without a type there (all
/// except pinholes, OpenCV's fisheye and f-theta). An ideal pinhole is an opencv-pinhole without distortion.
[[nodiscard]] Json camera_model_of(const Camera& camera);

inline constexpr const char* kUnknownLens = "unknown";

/// Returns a camera as in AlpaSim's rig_trajectories.json: {"logical_sensor_name", "sequence_id",
/// "unique_sensor_idx", "T_sensor_rig", "camera_model": {"type", "parameters"}}. The type is kUnknownLens for
/// lenses without a type; parameters of f-theta cameras are null for others.
[[nodiscard]] Json camera_calibration(const LogCamera& camera,
                                      const std::string& sequence,
                                      std::size_t index);

/// Returns the rows of a 4 x 4 matrix.
[[nodiscard]] Json rows_of(const Eigen::Matrix4d& matrix);

}  // namespace simuli
