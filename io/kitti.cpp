#include "io/kitti.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <regex>

#include "host/base/error.hpp"
#include "io/file.hpp"
#include "io/kitti_parts.hpp"
#include "io/lidar_file.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace kitti;

/// More points than this outside every beam mean another sensor or a damaged file.
constexpr double kMostUnplaced = 0.005;
/// A turn has 4 % more or fewer firings than the sensor's own number at most (8 to 12 Hz are far off).
constexpr double kColumnMargin = 0.04;

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
      if (!fs::is_regular_file(file)) {
        throw_input_error(file.string(), fmt::format("frame {} of {}", i, frames), "no such file", "a file");
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

BeamPoints read_beams(const fs::path& file, const Lidar& lidar, std::size_t& points) {
  const std::vector<Point> read = read_points(file);
  points = read.size();
  return sort_into_beams(read, lidar);
}

/// The beam table to read the sweeps with. Files are cut where a point's own azimuth is pi, whichever beam it
/// came from: a beam that looks further round fires there later, which the log's grid tells as a time offset.
Lidar read_beam_table(const fs::path& file, double sweep_duration_s) {
  if (file.empty()) return builtin_lidar("kitti_hdl64e");
  const LidarFile read = read_lidar_file(file);
  const auto* const table = std::get_if<Lidar>(&read.model);
  if (table == nullptr || table->spin != SpinDirection::kClockwise) {
    throw_input_error(file.string(),
                      table == nullptr ? "kind" : "spin",
                      table == nullptr ? "ray_list" : "counter_clockwise",
                      table == nullptr ? "lidar" : "clockwise, as KITTI's sensor turns");
  }
  Lidar lidar = *table;
  for (LidarRow& row : lidar.rows) {
    row.time_offset += row.azimuth_offset / (2.0 * std::numbers::pi) * sweep_duration_s;
    row.azimuth_offset = 0.0;
  }
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  return lidar;
}

/// The model with the firings per turn of this log and range limits that hold its points.
Lidar fit_lidar(const DriveFiles& files, std::size_t frames, Lidar lidar, KittiReport& report) {
  lidar.name = "velodyne";
  const int nominal = lidar.columns;
  double most_in_a_row = 0.0;
  std::vector<double> firings;  // per turn, of the sweeps that have enough points to tell
  for (std::size_t i = 0; i < frames; ++i) {
    std::size_t points = 0;
    const BeamPoints beams = read_beams(files.sweep(i), lidar, points);
    report.points += points;
    report.unplaced += beams.unplaced;
    report.ring_agrees += beams.ring_agrees;
    if (static_cast<double>(beams.unplaced) > kMostUnplaced * static_cast<double>(points)) {
      throw_input_error(files.sweep(i).string(),
                        "points outside every beam",
                        fmt::format("{} of {}", beams.unplaced, points),
                        fmt::format("at most {} %", 100.0 * kMostUnplaced));
    }
    const double estimate = estimate_columns(beams, lidar);
    if (estimate > 0.0) firings.push_back(estimate);
    for (std::size_t r = 0; r < beams.rows.size(); ++r) {
      most_in_a_row = std::max(most_in_a_row, static_cast<double>(beams.rows[r].size()));
      for (const Point& point : beams.rows[r]) {
        const double range = (point.position - lidar.origin(static_cast<int>(r), 0.0)).norm();
        lidar.range_min = std::min(lidar.range_min, range);
        lidar.range_max = std::max(lidar.range_max, range);
      }
    }
  }
  std::nth_element(
      firings.begin(), firings.begin() + static_cast<std::ptrdiff_t>(firings.size() / 2), firings.end());
  // Too few points to tell: the sensor's own number.
  const double typical = firings.empty() ? nominal : std::round(firings[firings.size() / 2]);
  const double columns = std::max(typical, most_in_a_row);
  if (!(std::abs(columns - nominal) <= nominal * kColumnMargin)) {
    throw_input_error((files.drive / "velodyne_points").string(),
                      "firings per turn",
                      fmt::format("{}", columns),
                      fmt::format("{} within {} %", nominal, 100.0 * kColumnMargin));
  }
  lidar.columns = static_cast<int>(columns);
  lidar.azimuth_first = std::numbers::pi * (1.0 - 1.0 / lidar.columns);
  return lidar;
}

void add_to_report(const Sweep& sweep, const Lidar& lidar, KittiReport& report) {
  report.rays += sweep.range.size();
  for (int r = 0; r < lidar.row_count(); ++r) {
    for (int c = 0; c < lidar.columns; ++c) {
      const auto ray =
          static_cast<std::size_t>(r) * static_cast<std::size_t>(lidar.columns) + static_cast<std::size_t>(c);
      if (sweep.range[ray] == 0.0F) continue;
      ++report.returned;
      const double shift =
          std::remainder(sweep.rays.azimuth[ray] - lidar.azimuth(r, c), 2.0 * std::numbers::pi);
      report.azimuth_shift_max_rad = std::max(report.azimuth_shift_max_rad, std::abs(shift));
    }
  }
}

}  // namespace

Log import_kitti(const KittiOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress,
                 KittiReport* report) {
  // "drive", "./drive/" and "." all have a name and a parent once they are absolute.
  const fs::path absolute = fs::absolute(options.drive).lexically_normal();
  const fs::path drive = absolute.has_filename() ? absolute : absolute.parent_path();
  const DriveFiles files{drive};
  const std::size_t frames = count_frames(files);
  const DriveTimes times = read_times(drive, frames);
  const bool from_oxts = options.poses.empty() && !options.without_poses;
  const Calibration calibration = read_calibration(drive.parent_path(), from_oxts);

  Log log;
  log.name = drive.filename().string();
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
  const double sweep_duration_s =
      static_cast<double>(times.end_ns[frames - 1] - times.start_ns[0]) * 1e-9 / static_cast<double>(frames);
  KittiReport counts;
  log.cameras = {{calibration.camera, calibration.cam02_from_velo.inverse()}};
  log.lidars = {{fit_lidar(files, frames, read_beam_table(options.lidar, sweep_duration_s), counts),
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
      std::size_t points = 0;
      const Sweep sweep = make_sweep(read_beams(files.sweep(i), lidar, points), lidar, sweep_duration_s);
      write_sweep(folder / sweep_file, sweep);
      add_to_report(sweep, lidar, counts);
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
