#include "tests/fuzz/readers.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include "host/sensors/lidar_library.hpp"
#include "io/image.hpp"
#include "io/kitti_parts.hpp"
#include "io/lidar_file.hpp"
#include "io/log.hpp"
#include "io/ply.hpp"
#include "io/scene_folder.hpp"
#include "io/splat_file.hpp"
#include "io/state_file.hpp"

namespace simuli::test {
namespace {

namespace fs = std::filesystem;

const Lidar& sweep_lidar() {
  static const Lidar lidar = [] {
    Lidar small = builtin_lidar("nuscenes_lidar_top_hdl32e");
    small.columns = 16;
    return small;
  }();
  return lidar;
}

/// A log's frames must be there, whatever is in them.
void read_log_beside_frames(const fs::path& file) {
  for (const char* frame : {"images/front_000000.png", "sweeps/top_000000.exr"}) {
    const fs::path path = file.parent_path() / frame;
    if (fs::exists(path)) continue;
    fs::create_directories(path.parent_path());
    std::ofstream(path).flush();
  }
  (void)read_log(file.parent_path());
}

constexpr std::array kReaders{
    FuzzedReader{"ply", [](const fs::path& f) { (void)read_gaussians_ply(f, SetKind::kCamera); }, "a.ply"},
    FuzzedReader{
        "ply_lidar", [](const fs::path& f) { (void)read_gaussians_ply(f, SetKind::kLidar); }, "a.ply"},
    FuzzedReader{"spz", [](const fs::path& f) { (void)read_spz(f); }, "a.spz"},
    FuzzedReader{"image", [](const fs::path& f) { (void)read_image(f); }, "a.png"},
    FuzzedReader{"sweep", [](const fs::path& f) { (void)read_sweep(f, sweep_lidar()); }, "a.exr"},
    FuzzedReader{"lidar", [](const fs::path& f) { (void)read_lidar_file(f); }, "a.json"},
    FuzzedReader{"log", read_log_beside_frames, "log.json"},
    FuzzedReader{"scene", [](const fs::path& f) { (void)read_scene(f.parent_path()); }, "scene.json"},
    FuzzedReader{"state",
                 [](const fs::path& f) {
                   const StateFile state(f);
                   for (const std::string& name : state.names()) (void)state.block(name);
                 },
                 "a.state"},
    FuzzedReader{
        "kitti_times", [](const fs::path& f) { (void)kitti::read_timestamps_ns(f); }, "timestamps.txt"},
    FuzzedReader{"kitti_keys", [](const fs::path& f) { (void)kitti::read_key_lines(f); }, "calib.txt"},
    FuzzedReader{"kitti_points", [](const fs::path& f) { (void)kitti::read_points(f); }, "0000000000.bin"},
    FuzzedReader{"kitti_poses",
                 [](const fs::path& f) {
                   (void)kitti::read_pose_file(f, {0, 100'000'000}, 0);
                 },
                 "poses.json"},
    FuzzedReader{"kitti_tracking",
                 [](const fs::path& f) {
                   kitti::SweepTimes times;
                   times.start_s = {0.0, 0.1};
                   times.end_s = {0.1, 0.2};
                   times.world_from_velo = Trajectory({{0.0, Pose{}}, {0.2, Pose{}}});
                   (void)kitti::read_tracking(f, Pose{}, times);
                 },
                 "0003.txt"},
};

}  // namespace

std::span<const FuzzedReader> fuzzed_readers() { return kReaders; }

}  // namespace simuli::test
