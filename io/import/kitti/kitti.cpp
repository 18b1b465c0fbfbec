#include "io/import/kitti/kitti.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <regex>
#include <system_error>

#include "host/base/error.hpp"
#include "host/base/names.hpp"
#include "io/base/file.hpp"
#include "io/base/regular_file.hpp"
#include "io/import/kitti/kitti_parts.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace kitti;

struct DriveFiles {
  fs::path drive;
  [[nodiscard]] fs::path image(std::size_t i) const {
    return drive / "image_02" / "data" / fmt::format("{:010}.png", i);
  }
  [[nodiscard]] fs::path sweep(std::size_t i) const {
    return drive / "velodyne_points" / "data" / fmt::format("{:010}.bin", i);
  }
};

/// Recorded times of every frame, one line each.
struct DriveTimes {
  std::vector<std::int64_t> image_ns, start_ns, forward_ns, end_ns;
};

/// One more than the highest number of a "NNNNNNNNNN.ending" in the folder.
std::size_t count_by_number(const fs::path& folder, const std::string& ending) {
  const std::regex form("[0-9]{10}\\." + ending);
  std::error_code status;
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(folder, status)) {
    const std::string name = entry.path().filename().string();
    if (std::regex_match(name, form)) count = std::max(count, std::size_t{std::stoull(name)} + 1);
  }
  if (status) throw_input_error(folder.string(), "folder", status.message(), "a readable folder");
  return count;
}

/// Frames up to the last that has an image or a sweep; each of them must have both.
std::size_t count_frames(const DriveFiles& files) {
  const fs::path images = files.image(0).parent_path();
  const fs::path sweeps = files.sweep(0).parent_path();
  const std::size_t frames = std::max(count_by_number(images, "png"), count_by_number(sweeps, "bin"));
  if (frames == 0) throw_input_error(images.string(), "frames", "none", "at least one NNNNNNNNNN.png");
  for (std::size_t i = 0; i < frames; ++i) {
    for (const fs::path& file : {files.image(i), files.sweep(i)}) {
      std::error_code failed;
      if (!fs::is_regular_file(file, failed)) {
        throw_input_error(file.string(),
                          fmt::format("frame {} of {}", i, frames),
                          failed && is_there(file) ? failed.message() : "no such file",
                          "a file");
      }
    }
  }
  return frames;
}

DriveTimes read_times(const fs::path& drive, std::size_t frames) {
  const auto read = [&](const fs::path& file) {
    std::vector<std::int64_t> times = read_timestamps_ns(file);
    if (times.size() < frames) {
      throw_input_error(file.string(),
                        "lines",
                        std::to_string(times.size()),
                        fmt::format("at least {}, one per frame", frames));
    }
    for (std::size_t i = 1; i < frames; ++i) {
      if (times[i] >= times[i - 1]) continue;
      throw_input_error(file.string(),
                        fmt::format("line {}", i + 1),
                        "a time before that of the line above",
                        "lines in order of time");
    }
    return times;
  };
  const fs::path sweeps = drive / "velodyne_points";
  DriveTimes times{read(drive / "image_02" / "timestamps.txt"),
                   read(sweeps / "timestamps_start.txt"),
                   read(sweeps / "timestamps.txt"),
                   read(sweeps / "timestamps_end.txt")};
  for (std::size_t i = 0; i < frames; ++i) {
    if (times.start_ns[i] < times.forward_ns[i] && times.forward_ns[i] < times.end_ns[i]) continue;
    throw_input_error((sweeps / "timestamps.txt").string(),
                      fmt::format("line {}", i + 1),
                      "a time outside the sweep",
                      "a time between those of timestamps_start.txt and timestamps_end.txt");
  }
  return times;
}

}  // namespace

Log import_kitti(const KittiOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress,
                 KittiReport* report) {
  // "drive", "./drive/" and "." all have a name and a parent once they are absolute.
  const fs::path absolute = (fs::current_path() / options.drive).lexically_normal();
  const fs::path drive = absolute.has_filename() ? absolute : absolute.parent_path();
  const DriveFiles files{drive};
  const std::size_t frames = count_frames(files);
  const DriveTimes times = read_times(drive, frames);
  const bool from_oxts = options.poses.empty() && !options.without_poses;
  const Calibration calibration = read_calibration(drive.parent_path(), from_oxts);

  Log log;
  log.name = name_from(drive.filename().string());
  log.start_ns = std::min(times.start_ns[0], times.image_ns[0]);
  const auto seconds = [&](std::int64_t ns) { return static_cast<double>(ns - log.start_ns) * 1e-9; };
  if (options.without_poses) {
    log.world_from_rig = Trajectory({{0.0, Pose{}}, {seconds(times.end_ns[frames - 1]), Pose{}}});
  } else if (from_oxts) {
    log.world_from_rig = read_oxts(drive, frames, calibration.velo_from_imu, log.start_ns);
  } else {
    log.world_from_rig = read_pose_file(options.poses, times.forward_ns, log.start_ns);
  }
  if (!options.tracking.empty()) {
    SweepTimes sweeps{{}, {}, log.world_from_rig};
    for (std::size_t i = 0; i < frames; ++i) {
      sweeps.start_s.push_back(seconds(times.start_ns[i]));
      sweeps.end_s.push_back(seconds(times.end_ns[i]));
    }
    log.actors = read_tracking(options.tracking, calibration.rect00_from_velo, sweeps);
  }
  const double sweep_s =
      static_cast<double>(times.end_ns[frames - 1] - times.start_ns[0]) * 1e-9 / static_cast<double>(frames);
  KittiReport counts;
  log.cameras = {{calibration.camera, calibration.cam02_from_velo.inverse()}};
  std::vector<fs::path> sweeps;
  for (std::size_t i = 0; i < frames; ++i) sweeps.push_back(files.sweep(i));
  log.lidars = {{fit_lidar(sweeps, read_beam_table(options.lidar, sweep_s), counts),
                 Pose{}}};  // the rig's frame is the velodyne's

  Log imported;
  write_folder_atomically(options.output, [&](const fs::path& folder) {
    log.folder = folder;
    fs::create_directory(folder / "images");
    fs::create_directory(folder / "sweeps");
    const Lidar& lidar = log.lidars[0].with_rows();
    for (std::size_t i = 0; i < frames; ++i) {
      const std::string image_file = fmt::format("images/{:010}.png", i);
      const std::string sweep_file = fmt::format("sweeps/{:010}.exr", i);
      copy_picture(files.image(i), folder / image_file, calibration.camera, "S_rect_02");
      write_sweep(folder / sweep_file, read_turn(sweeps[i], lidar, counts));
      const double image_s = seconds(times.image_ns[i]);
      log.images.push_back({calibration.camera.name, image_file, image_s, image_s});
      log.sweeps.push_back({lidar.name, sweep_file, seconds(times.start_ns[i]), seconds(times.end_ns[i])});
      if (progress) progress(i + 1, frames);
    }
    write_log(log);
    imported = read_log(folder);  // what was written is what the next command will read
  });
  imported.folder = options.output;
  if (report != nullptr) *report = counts;
  return imported;
}

}  // namespace simuli
