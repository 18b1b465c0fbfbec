#include "io/import/kitti/kitti.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <optional>
#include <regex>
#include <system_error>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/base/file.hpp"
#include "io/import/kitti/kitti_parts.hpp"
#include "io/log/new_log.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace kitti;

/// KITTI's cameras and velodyne run at 10 Hz.
constexpr std::int64_t kFrame_ns = 100'000'000;

/// A sensor's recordings: files "FOLDER/data/NNNNNNNNNN.ENDING", and times, one line per frame.
struct Recorder {
  std::string name;
  fs::path folder;
  std::string ending;
  std::vector<std::size_t> present, absent, disordered;  // of the requested frames

  [[nodiscard]] fs::path file(std::size_t frame) const {
    return folder / "data" / fmt::format("{:010}.{}", frame, ending);
  }
  [[nodiscard]] bool has(std::size_t frame) const {
    return std::binary_search(present.begin(), present.end(), frame);
  }
};

/// Returns 1 + the highest number of the sensor's files.
std::size_t count_by_number(const Recorder& recorder) {
  const std::regex form("[0-9]{10}\\." + recorder.ending);
  const fs::path folder = recorder.folder / "data";
  std::error_code status;
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(folder, status)) {
    const std::string name = entry.path().filename().string();
    if (std::regex_match(name, form)) count = std::max(count, std::size_t{std::stoull(name)} + 1);
  }
  if (status)
    throw_input_error(
        folder.string(), "folder", status.message(), "what a KITTI raw drive (..._sync) has in it");
  return count;
}

/// Returns the requested frames of the `count` frames of the drive.
Frames frames_of(const KittiOptions& options, std::size_t count) {
  const bool is_open = options.last == KittiOptions{}.last;
  const Frames frames{options.first, is_open ? count - 1 : options.last};
  if (frames.first <= frames.last && frames.last < count) return frames;
  throw_input_error(options.drive.string(),
                    "frames",
                    fmt::format("{} to {}", frames.first, frames.last),
                    fmt::format("first to last from 0 to {}, which the drive has", count - 1));
}

/// Finds the existing frames. Missing and empty files are gaps: recorders lose sweeps.
void find_frames(Recorder& recorder, const Frames& frames) {
  for (std::size_t i = frames.first; i <= frames.last; ++i) {
    const fs::path file = recorder.file(i);
    std::error_code failed, ignored;
    const bool is_file = fs::is_regular_file(file, failed);
    if (!is_file && is_there(file)) {
      throw_input_error(file.string(),
                        fmt::format("frame {} of {} to {}", i, frames.first, frames.last),
                        failed ? failed.message() : "something that is no file",
                        "a file");
    }
    const bool is_lost = !is_file || (recorder.ending == "bin" && fs::file_size(file, ignored) == 0);
    (is_lost ? recorder.absent : recorder.present).push_back(i);
  }
  if (!recorder.present.empty()) return;
  throw_input_error((recorder.folder / "data").string(),
                    "frames",
                    fmt::format("none of {} to {}", frames.first, frames.last),
                    fmt::format("at least one NNNNNNNNNN.{} with something in it", recorder.ending));
}

/// Removes frames with times out of order.
void leave_out(Recorder& recorder, const std::vector<std::size_t>& frames) {
  for (const std::size_t frame : frames) {
    const auto found = std::lower_bound(recorder.present.begin(), recorder.present.end(), frame);
    if (found == recorder.present.end() || *found != frame) continue;
    recorder.present.erase(found);
    recorder.disordered.push_back(frame);
  }
}

/// Returns the times of all frames of the drive from the sensor's file of that name. Times of existing frames
/// are as recorded; blank or missing lines (lost frames) and times out of order are interpolated between their
/// neighbours.
std::vector<std::int64_t> read_times(Recorder& recorder, const char* name, std::size_t count) {
  const fs::path file = recorder.folder / name;
  std::vector<std::optional<std::int64_t>> lines = read_lines_ns(file);
  const std::size_t needed = recorder.present.back() + 1;
  if (lines.size() < needed) {
    throw_input_error(file.string(),
                      "lines",
                      std::to_string(lines.size()),
                      fmt::format("at least {}, one per frame", needed));
  }
  for (const std::size_t frame : recorder.present) {
    if (lines[frame]) continue;
    throw_input_error(file.string(),
                      fmt::format("line {}", frame + 1),
                      "nothing",
                      fmt::format("the time of {}", recorder.file(frame).filename().string()));
  }
  leave_out(recorder, take_disordered(lines));
  if (recorder.present.empty())
    throw_input_error(file.string(), "times", "none of the frames' in order", "times that rise");
  std::vector<std::int64_t> times;
  std::size_t before = count;  // the previous frame with a time
  for (std::size_t i = 0; i < std::min(count, lines.size()); ++i) {
    if (!lines[i]) continue;
    // Before the first known time, and after it if there is no other, frames have KITTI's period.
    const bool is_first = before == count;
    const std::int64_t step =
        is_first ? kFrame_ns : (*lines[i] - *lines[before]) / static_cast<std::int64_t>(i - before);
    while (times.size() < i) times.push_back(*lines[i] - step * static_cast<std::int64_t>(i - times.size()));
    times.push_back(*lines[i]);
    before = i;
  }
  while (times.size() < count) times.push_back(times.back() + kFrame_ns);
  return times;
}

/// Start and end of a sweep, by frame.
struct SweepNs {
  std::vector<std::int64_t> start, forward, end;
};

SweepNs read_sweep_times(Recorder& velodyne, std::size_t count) {
  SweepNs times{read_times(velodyne, "timestamps_start.txt", count),
                read_times(velodyne, "timestamps.txt", count),
                read_times(velodyne, "timestamps_end.txt", count)};
  for (const std::size_t i : velodyne.present) {
    if (times.start[i] < times.forward[i] && times.forward[i] < times.end[i]) continue;
    throw_input_error((velodyne.folder / "timestamps.txt").string(),
                      fmt::format("line {}", i + 1),
                      "a time outside the sweep",
                      "a time between those of timestamps_start.txt and timestamps_end.txt");
  }
  return times;
}

/// Returns the indices in `present` after gaps in time that are longer than those between other consecutive
/// frames.
std::vector<std::size_t> jumps_of(const Recorder& recorder, const std::vector<std::int64_t>& times) {
  constexpr std::int64_t kMost_ns = 500'000'000;
  const std::vector<std::size_t>& frames = recorder.present;
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    steps.push_back((times[frames[i]] - times[frames[i - 1]]) /
                    static_cast<std::int64_t>(frames[i] - frames[i - 1]));
  }
  if (steps.empty()) return {};
  std::vector<std::int64_t> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  std::vector<std::size_t> jumps;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto between = static_cast<std::int64_t>(frames[i + 1] - frames[i]);
    if ((steps[i] - *middle) * between > kMost_ns) jumps.push_back(i + 1);
  }
  return jumps;
}

/// Returns the mean sweep period in s, without the gaps.
double revolution_s(const Recorder& velodyne, const SweepNs& times) {
  const std::vector<std::size_t>& frames = velodyne.present;
  std::int64_t ns = times.end[frames.back()] - times.start[frames.front()];
  std::size_t turns = frames.back() - frames.front() + 1;
  for (const std::size_t i : jumps_of(velodyne, times.start)) {
    ns -= times.start[frames[i]] - times.start[frames[i - 1]];
    turns -= frames[i] - frames[i - 1];
  }
  return static_cast<double>(ns) * 1e-9 / static_cast<double>(turns);
}

std::vector<Recorder> cameras_of(const KittiOptions& options, const fs::path& drive) {
  std::vector<Recorder> cameras;
  const std::vector<std::string> left = {"image_02"};
  for (const std::string& name : options.cameras.empty() ? left : options.cameras) {
    (void)index_of_name(name, {"image_00", "image_01", "image_02", "image_03"}, "cameras");
    const bool is_twice = std::any_of(
        cameras.begin(), cameras.end(), [&](const Recorder& camera) { return camera.name == name; });
    if (is_twice) throw Error(ErrorKind::kUsage, fmt::format("cameras: found {} twice, allowed once", name));
    cameras.push_back({name, drive / name, "png", {}, {}, {}});
  }
  return cameras;
}

/// Calibration is distributed in separate archives that users may forget.
void need_calibration(const fs::path& date_folder, bool from_oxts, const fs::path& drive) {
  if (from_oxts && !is_there(drive / "oxts")) {
    throw_input_error((drive / "oxts").string(),
                      "folder",
                      "no such folder",
                      "poses of oxts, of a file (--poses), or none (--no-poses, then simuli align)");
  }
  for (const char* name : {"calib_cam_to_cam.txt", "calib_velo_to_cam.txt", "calib_imu_to_velo.txt"}) {
    if (is_there(date_folder / name) || (std::string(name) == "calib_imu_to_velo.txt" && !from_oxts))
      continue;
    throw_input_error((date_folder / name).string(),
                      "file",
                      "no such file",
                      "the calibration of the date in the folder above the drive");
  }
}

}  // namespace

Log import_kitti(const KittiOptions& options, const FrameProgress& progress, KittiReport* report) {
  // Absolute, so that "drive", "./drive/" and "." all have a name and a parent.
  const fs::path absolute = (fs::current_path() / options.drive).lexically_normal();
  const fs::path drive = absolute.has_filename() ? absolute : absolute.parent_path();
  std::vector<Recorder> recorders = cameras_of(options, drive);
  std::vector<std::string> names;
  for (const Recorder& camera : recorders) names.push_back(camera.name);
  recorders.push_back({"velodyne", drive / "velodyne_points", "bin", {}, {}, {}});
  std::size_t count = 0;
  for (const Recorder& recorder : recorders) count = std::max(count, count_by_number(recorder));
  if (count == 0) {
    throw_input_error(
        (recorders[0].folder / "data").string(), "frames", "none", "at least one NNNNNNNNNN.png");
  }
  const Frames frames = frames_of(options, count);
  for (Recorder& recorder : recorders) find_frames(recorder, frames);
  Recorder& velodyne = recorders.back();
  const SweepNs times = read_sweep_times(velodyne, count);
  const bool from_oxts = options.poses.empty() && !options.without_poses;
  need_calibration(drive.parent_path(), from_oxts, drive);
  const Calibration calibration = read_calibration(drive.parent_path(), from_oxts, names);

  KittiReport counts;
  Log log;
  log.name = name_from(drive.filename().string());
  std::vector<std::vector<std::int64_t>> picture_ns;
  log.start_ns = times.start[frames.first];
  for (std::size_t c = 0; c + 1 < recorders.size(); ++c) {
    picture_ns.push_back(read_times(recorders[c], "timestamps.txt", count));
    log.start_ns = std::min(log.start_ns, picture_ns[c][frames.first]);
  }
  const auto seconds = [&](std::int64_t ns) { return static_cast<double>(ns - log.start_ns) * 1e-9; };
  const bool to_the_end = frames.last + 1 == count;
  Frames path = frames.with_margin(kPathMargin);
  if (to_the_end) path.last = KittiOptions{}.last;
  Recorder oxts{"oxts", {}, {}, {}, {}, {}};
  if (options.without_poses) {
    log.world_from_rig = Trajectory({{0.0, Pose{}}, {seconds(times.end[frames.last]), Pose{}}});
  } else if (from_oxts) {
    log.world_from_rig =
        read_oxts(drive, frames, path, calibration.velo_from_imu, log.start_ns, oxts.absent, oxts.disordered);
  } else {
    log.world_from_rig = read_pose_file(options.poses, times.forward, log.start_ns, path);
  }
  if (!options.tracking.empty()) {
    SweepTimes sweeps{{}, {}, log.world_from_rig, frames.first};
    for (std::size_t i = frames.first; i <= frames.last; ++i) {
      sweeps.start_s.push_back(seconds(times.start[i]));
      sweeps.end_s.push_back(seconds(times.end[i]));
    }
    log.actors = read_tracking(options.tracking, calibration.rect00_from_velo, sweeps, counts.labels);
  }
  for (std::size_t i = 0; i < recorders.size(); ++i) {
    const std::vector<std::int64_t>& ns = i < picture_ns.size() ? picture_ns[i] : times.start;
    for (const std::size_t at : jumps_of(recorders[i], ns)) {
      const std::size_t frame = recorders[i].present[at], before = recorders[i].present[at - 1];
      counts.jumps.push_back({recorders[i].name, frame, static_cast<double>(ns[frame] - ns[before]) * 1e-9});
    }
  }
  std::vector<Recorder> all = recorders;
  all.push_back(oxts);
  for (const Recorder& recorder : all) {
    if (!recorder.absent.empty()) counts.gaps.push_back({recorder.name, recorder.absent});
    if (!recorder.disordered.empty()) counts.disordered.push_back({recorder.name, recorder.disordered});
  }
  log.cameras = calibration.cameras;
  std::vector<fs::path> sweeps;
  for (const std::size_t i : velodyne.present) sweeps.push_back(velodyne.file(i));
  log.lidars = {{fit_lidar(sweeps, read_beam_table(options.lidar, revolution_s(velodyne, times)), counts),
                 Pose{}}};  // the rig's frame is the velodyne's

  Log imported = make_import(options.output, log, [&] {
    LogMaker maker(log, progress, frames.last - frames.first + 1);
    const Lidar& lidar = log.lidars[0].with_rows();
    for (std::size_t i = frames.first; i <= frames.last; ++i) {
      for (std::size_t c = 0; c < log.cameras.size(); ++c) {
        if (!recorders[c].has(i)) continue;
        const Camera& camera = log.cameras[c].model;
        const double time_s = seconds(picture_ns[c][i]);
        maker.add_picture(camera,
                          fmt::format("{}_{:010}", camera.name, i),
                          recorders[c].file(i),
                          "S_rect_" + camera.name.substr(6),
                          {time_s, time_s});
      }
      if (velodyne.has(i)) {
        maker.add_sweep(lidar.name,
                        fmt::format("{:010}", i),
                        read_sweep_file(velodyne.file(i), lidar, counts),
                        {seconds(times.start[i]), seconds(times.end[i])});
      }
      maker.step();
    }
  });
  if (report != nullptr) *report = counts;
  return imported;
}

}  // namespace simuli
