#include "tests/fuzz/readers.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "host/core/sensors/lidar_library.hpp"
#include "io/bag/bag.hpp"
#include "io/base/file.hpp"
#include "io/base/gzip.hpp"
#include "io/base/state_file.hpp"
#include "io/import/kitti/kitti_parts.hpp"
#include "io/import/kitti360/kitti360_parts.hpp"
#include "io/import/nuscenes/nuscenes.hpp"
#include "io/import/nuscenes/nuscenes_sweep.hpp"
#include "io/import/pandaset/data_frame.hpp"
#include "io/import/photos/photo_log.hpp"
#include "io/import/points/points_log.hpp"
#include "io/import/ros2/ros2_frames.hpp"
#include "io/import/ros2/ros2_lidar.hpp"
#include "io/import/ros2/ros2_scan.hpp"
#include "io/import/waymo/waymo_frame.hpp"
#include "io/log/log.hpp"
#include "io/log/sensor_file.hpp"
#include "io/picture/image.hpp"
#include "io/ros2/camera_info.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/splat_file.hpp"
#include "tests/fuzz/ncore_readers.hpp"

namespace simuli::test {
namespace {

namespace fs = std::filesystem;

const Lidar& sweep_lidar() {
  static const Lidar lidar = [] {
    Lidar small = builtin_lidar("nuscenes_lidar_top_hdl32e");
    small.columns = 2;
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

/// What stands beside scene.json is as its seed says.
void read_scene_beside_sets(const fs::path& file) {
  const fs::path folder = file.parent_path(), whole = folder / "whole";
  if (!fs::exists(whole)) {
    SceneFile made;
    made.scene.camera = GaussianSet(SetKind::kCamera, 1, 2);
    made.scene.lidar = GaussianSet(SetKind::kLidar, 0, 2);
    for (GaussianSet* set : {&made.scene.camera, &made.scene.lidar}) set->rotation().col(0).setOnes();
    made.scene.environment = {4, 2, std::vector<float>(3 * 4 * 2, 0.5F)};
    ColorGrids& grids = made.scene.color_grids;
    grids.size_x = grids.size_y = grids.size_z = 2;
    grids.frames = {{"front", 0.0}};
    grids.values.assign(grids.values_per_frame(), 0.25F);
    write_scene(whole, made);
    fs::remove(whole / "scene.json");
    for (const auto& entry : fs::directory_iterator(whole)) {
      fs::copy_file(entry.path(), folder / entry.path().filename(), fs::copy_options::overwrite_existing);
    }
  }
  (void)read_scene(folder);
}

/// The files of a format that has several, one after the other with "%%%%" between them; beside `file`.
void split(const fs::path& file, std::initializer_list<const char*> names) {
  constexpr std::string_view kBetween = "%%%%";
  const std::string all = read_file(file);
  std::string_view rest = all;
  for (const char* name : names) {
    const std::size_t end = rest.find(kBetween);
    const fs::path part = file.parent_path() / name;
    fs::create_directories(part.parent_path());
    std::ofstream(part, std::ios::binary) << rest.substr(0, end);
    rest = end == std::string_view::npos ? "" : rest.substr(end + kBetween.size());
  }
}

void read_colmap_text(const fs::path& file) {
  split(file, {"cameras.txt", "images.txt", "points3D.txt"});
  (void)read_colmap({file.parent_path(), "photos", {}});
}

void read_colmap_binary(const fs::path& file) {
  split(file, {"cameras.bin", "images.bin", "points3D.bin"});
  (void)read_colmap({file.parent_path(), "photos", {}});
}

/// The tables are read before any picture or sweep, and the one that is there is empty: never a whole log.
void read_nuscenes_tables(const fs::path& file) {
  split(file,
        {"v1.0-mini/scene.json",
         "v1.0-mini/sample.json",
         "v1.0-mini/sensor.json",
         "v1.0-mini/calibrated_sensor.json",
         "v1.0-mini/sample_data.json",
         "v1.0-mini/ego_pose.json",
         "v1.0-mini/category.json",
         "v1.0-mini/instance.json",
         "v1.0-mini/sample_annotation.json"});
  const fs::path picture = file.parent_path() / "samples/0.jpg";
  fs::create_directories(picture.parent_path());
  std::ofstream(picture).flush();
  NuscenesReport report;
  (void)import_nuscenes({file.parent_path(), "v1.0-mini", "", file.parent_path() / "out"}, {}, report);
}

/// A JSON chunk and a binary one, with the headers around them that they ask for.
void read_glb_parts(const fs::path& file) {
  const std::string all = read_file(file);
  const std::size_t end = all.find(kBetweenParts);
  const std::string json = all.substr(0, end);
  const std::string binary =
      end == std::string::npos ? "" : all.substr(end + std::string_view(kBetweenParts).size());
  std::string bytes("glTF\x02\x00\x00\x00", 8);
  append_number(bytes, static_cast<std::uint32_t>(28 + json.size() + binary.size()));
  append_number(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  append_number(bytes, static_cast<std::uint32_t>(binary.size()));
  bytes += std::string("BIN\x00", 4) + binary;
  (void)read_glb(bytes, file.string());
}

void read_nuscenes_sweep(const fs::path& file) {
  const Lidar lidar = nuscenes::lidar_of({file}, "top");
  (void)nuscenes::read_turn(file, lidar, Pose{Eigen::Quaterniond::Identity(), {0.0, 0.1, 0.0}});
}

/// points.json, then the points of its one sweep.
void read_point_drive(const fs::path& file) {
  split(file, {"points.json", "points/0.bin"});
  const fs::path log = file.parent_path() / "log";
  PointReport report;
  (void)import_points({file.parent_path(), log}, {}, report);
  fs::remove_all(log);
}

/// All that an import makes of the bytes, but for writing it: that takes a hundred times as long.
void read_recording(const fs::path& file) {
  const std::string name = file.string();
  Ros2Options options;
  options.recording = file;
  options.lidars = {{"/top/points", sweep_lidar()}};
  Lidar& table = options.lidars[0].table;
  table.columns = 8;  // the seeds' points have four azimuths
  const auto bag = open_bag(file);
  const ros2::Scan scan = ros2::scan_bag(*bag, options);
  std::string world;
  (void)scan.transforms.path(options.rig_frame, world);
  for (const auto& [topic, info] : scan.infos) (void)ros2::camera_of(info, "front", name, topic);
  for (const auto& [topic, cloud] : scan.clouds) {
    (void)scan.transforms.fixed(options.rig_frame, cloud.frame_id);
    if (!cloud.fields) continue;
    const auto lidar = ros2::fit_recorded(
        options.lidars[0], cloud.first_sweeps, table.sweep_s, ros2::Stamp::kUnknown, name, topic);
    PointReport report;
    for (const auto& sweep : cloud.first_sweeps)
      (void)grid_points(ros2::measured(sweep, lidar, name, topic), lidar.model, report);
  }
  const auto is_picture = [](const BagChannel& channel) { return channel.type == ros2::kImage; };
  bag->read(is_picture, [&](const BagChannel& channel, std::uint64_t, std::string_view data) {
    (void)ros2::picture_of(
        ros2::read_image_message(ros2::reader_of(channel, data, name)), name, channel.topic);
  });
}

void read_messages(const fs::path& file) {
  std::size_t bytes = 0;
  open_bag(file)->read([](const BagChannel&) { return true; },
                       [&](const BagChannel& channel, std::uint64_t, std::string_view data) {
                         bytes += channel.topic.size() + data.size();
                       });
}

/// A frame's message with its sensors; the range image as it is before compression, which no change of the
/// compressed bytes would get past.
void read_waymo_frame(const fs::path& file) {
  const std::string bytes = read_file(file);
  const waymo::Reader reader(file.string());
  const waymo::Frame frame = reader.frame(bytes);
  for (const std::string_view camera : frame.cameras) (void)reader.camera(camera);
  for (const waymo::Picture& picture : frame.pictures) (void)reader.camera_name(picture.name);
  if (frame.top.empty()) return;
  const waymo::Grid grid = reader.grid(gzip(std::string(frame.top)));
  for (const std::string_view calibration : frame.lidars) {
    LogLidar lidar;
    if (reader.lidar(calibration, grid.rows, grid.columns, lidar)) {
      (void)waymo::sweep_of(grid, lidar.with_rows());
    }
  }
}

void read_waymo_records(const fs::path& file) {
  const waymo::Reader reader(file.string());
  TfRecords records(file);
  std::string record;
  while (records.next(record)) {
    const waymo::Frame frame = reader.frame(record);
    if (!frame.top.empty()) (void)reader.grid(frame.top);
  }
}

/// Columns that the seeds have, as numbers and as texts.
void read_pandas_table(const fs::path& file) {
  const pandaset::DataFrame table(file);
  for (const char* const column : {"x", "d"}) (void)table.numbers(column);
  (void)table.texts("label");
}

#ifdef SIMULI_TEST_SQLITE
constexpr bool kHasSqlite = true;
#else
constexpr bool kHasSqlite = false;
#endif

constexpr std::array kReaders{
    FuzzedReader{
        "ply", Form::kPly, [](const fs::path& f) { (void)read_gaussians_ply(f, SetKind::kCamera); }, "a.ply"},
    FuzzedReader{"ply_compressed",
                 Form::kPly,
                 [](const fs::path& f) { (void)read_gaussians_ply(f, SetKind::kCamera); },
                 "a.ply"},
    FuzzedReader{"ply_points", Form::kPly, [](const fs::path& f) { (void)read_points_ply(f); }, "a.ply"},
    FuzzedReader{"ply_lidar",
                 Form::kPly,
                 [](const fs::path& f) { (void)read_gaussians_ply(f, SetKind::kLidar); },
                 "a.ply"},
    FuzzedReader{"spz", Form::kSpz, [](const fs::path& f) { (void)read_spz(f); }, "a.spz"},
    FuzzedReader{"glb", Form::kJson, read_glb_parts, "a.glb"},
    FuzzedReader{"image", Form::kBytes, [](const fs::path& f) { (void)read_image(f); }, "a.png"},
    FuzzedReader{"sweep", Form::kExr, [](const fs::path& f) { (void)read_sweep(f, sweep_lidar()); }, "a.exr"},
    FuzzedReader{"sensor", Form::kJson, [](const fs::path& f) { (void)read_sensor_file(f); }, "a.json"},
    FuzzedReader{"log", Form::kJson, read_log_beside_frames, "log.json"},
    FuzzedReader{"scene", Form::kJson, read_scene_beside_sets, "scene.json"},
    FuzzedReader{"state",
                 Form::kBytes,
                 [](const fs::path& f) {
                   const StateFile state(f);
                   for (const std::string& name : state.names()) (void)state.block(name);
                 },
                 "a.state"},
    FuzzedReader{"kitti_times",
                 Form::kText,
                 [](const fs::path& f) { (void)kitti::read_timestamps_ns(f); },
                 "timestamps.txt"},
    FuzzedReader{
        "kitti_keys", Form::kText, [](const fs::path& f) { (void)kitti::read_key_lines(f); }, "calib.txt"},
    FuzzedReader{"kitti_points",
                 Form::kBytes,
                 [](const fs::path& f) { (void)kitti::read_points(f); },
                 "0000000000.bin"},
    FuzzedReader{"kitti_poses",
                 Form::kJson,
                 [](const fs::path& f) {
                   (void)kitti::read_pose_file(f, {0, 100'000'000}, 0, {0, 1});
                 },
                 "poses.json"},
    FuzzedReader{"kitti_tracking",
                 Form::kText,
                 [](const fs::path& f) {
                   kitti::SweepTimes times;
                   times.start_s = {0.0, 0.1};
                   times.end_s = {0.1, 0.2};
                   times.world_from_velo = Trajectory({{0.0, Pose{}}, {0.2, Pose{}}});
                   LabelReport report;
                   (void)kitti::read_tracking(f, Pose{}, times, report);
                 },
                 "0003.txt"},
    FuzzedReader{"kitti360_camera",
                 Form::kText,
                 [](const fs::path& f) { (void)kitti360::read_fisheye(f, "image_02"); },
                 "image_02.yaml"},
    FuzzedReader{
        "kitti360_poses", Form::kText, [](const fs::path& f) { (void)kitti360::read_poses(f); }, "poses.txt"},
    FuzzedReader{"colmap_text", Form::kText, read_colmap_text, "model"},
    FuzzedReader{"colmap_binary", Form::kBytes, read_colmap_binary, "model"},
    FuzzedReader{"nerfstudio",
                 Form::kJson,
                 [](const fs::path& f) {
                   (void)read_nerfstudio({f, {}});
                 },
                 "transforms.json"},
    FuzzedReader{"nuscenes_tables", Form::kJson, read_nuscenes_tables, "tables", false},
    FuzzedReader{"nuscenes_sweep", Form::kBytes, read_nuscenes_sweep, "0.pcd.bin"},
    FuzzedReader{"pandas", Form::kBytes, read_pandas_table, "00.pkl.gz"},
    FuzzedReader{"points", Form::kJson, read_point_drive, "drive"},
    FuzzedReader{"mcap", Form::kMcap, read_recording, "a.mcap"},
    FuzzedReader{"rosbag2", Form::kBytes, read_messages, "a.db3", kHasSqlite},
    FuzzedReader{"itar", Form::kBytes, read_itar_parts, "a.itar"},
    FuzzedReader{"zarr", Form::kJson, read_zarr_parts, "array"},
    FuzzedReader{"ncore", Form::kJson, read_ncore_parts, "sequence"},
    FuzzedReader{"waymo_frame", Form::kWire, read_waymo_frame, "frame"},
    FuzzedReader{"waymo_records", Form::kRecords, read_waymo_records, "segment.tfrecord"},
};

}  // namespace

std::span<const FuzzedReader> fuzzed_files() { return kReaders; }

}  // namespace simuli::test
