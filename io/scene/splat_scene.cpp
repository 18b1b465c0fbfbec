#include "io/scene/splat_scene.hpp"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/scene/mounting.hpp"
#include "host/core/scene/placement.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "io/splat/splat_axes.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

Camera orbit_camera() {
  constexpr int kWidth = 1280, kHeight = 720;
  Camera camera;
  camera.name = "orbit";
  camera.width = kWidth;
  camera.height = kHeight;
  camera.fx = camera.fy = 0.5 * kWidth / std::tan(30.0 * kDegree);
  camera.cx = 0.5 * kWidth;
  camera.cy = 0.5 * kHeight;
  return camera;
}

/// Returns a circular trajectory whose x axis points at the box's centre.
Trajectory around(const Eigen::AlignedBox3d& box) {
  constexpr double kSeconds = 10.0, kElevation = 20.0 * kDegree, kNearest_m = 0.5;
  constexpr int kPoses = 101;
  // Half of a picture's height is 18 degrees: a sphere fits from a distance of 3.2 radii.
  const double away_m = std::max(3.2 * 0.5 * box.diagonal().norm(), kNearest_m);
  std::vector<TimedPose> poses;
  for (int i = 0; i < kPoses; ++i) {
    const double share = static_cast<double>(i) / (kPoses - 1);
    const Eigen::Quaterniond inwards(Eigen::AngleAxisd(kTurn * share, Eigen::Vector3d::UnitZ()) *
                                     Eigen::AngleAxisd(kElevation, Eigen::Vector3d::UnitY()));
    poses.push_back(
        {kSeconds * share, {inwards, box.center() - inwards * Eigen::Vector3d(away_m, 0.0, 0.0)}});
  }
  return Trajectory(std::move(poses));
}

}  // namespace

bool is_splat_file(const fs::path& file) {
  std::error_code ignored;
  return has_splat_extension(file) && !fs::is_directory(file, ignored);
}

SceneFile scene_of_splats(const fs::path& file, const SplatPlacement& placement) {
  SplatReport report;
  SceneFile out = scene_of_splats(read_splats(file, &report), file, placement);
  out.splats = report;
  return out;
}

SceneFile scene_of_splats(GaussianSet splats, const fs::path& file, const SplatPlacement& placement) {
  const Eigen::Quaterniond level = level_from(placement.axes);
  SceneFile out;
  Scene& scene = out.scene;
  scene.name = name_from(file.stem().string());
  scene.camera = std::move(splats);
  scene.camera_filter_px2 = kSplatVariance_px2;
  if (!scene.camera.actor.empty()) {
    throw_input_error(
        file.string(), "actor", "particles of actors, in frames of their own", "the scene's folder");
  }
  const Pose world_from_file = placement.world_from_model * Pose{level, Eigen::Vector3d::Zero()};
  // Particles are floats: a local origin keeps their coordinates small.
  scene.origin = world_from_file.translation;
  transform(scene.camera, {world_from_file.rotation, Eigen::Vector3d::Zero()}, placement.metres_per_unit);
  Eigen::AlignedBox3d box = extent_of(scene.camera);
  if (box.isEmpty()) throw_input_error(file.string(), "particles", "none", "at least one");
  scene.lidar = lidar_of(scene.camera);
  out.cameras.push_back({orbit_camera(), {kForwardFromCamera, Eigen::Vector3d::Zero()}});
  out.lidars.push_back({builtin_lidar("hesai_xt32"), {}});
  out.world_from_rig = around(box.translate(scene.origin));
  const std::vector<TimedPose>& poses = out.world_from_rig.poses();
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    const double start_s = poses[i].time_s;
    out.recorded_frames["orbit"].push_back({start_s, start_s});
    out.recorded_frames["hesai_xt32"].push_back({start_s, poses[i + 1].time_s});
  }
  return out;
}

}  // namespace simuli
