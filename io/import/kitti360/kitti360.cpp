#include "io/import/kitti360/kitti360.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/base/file.hpp"
#include "io/import/kitti/kitti_parts.hpp"
#include "io/import/kitti360/kitti360_parts.hpp"
#include "io/log/new_log.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace kitti360;

constexpr double kRevolution_s = 0.1;     // of the sensor, if the neighbouring frames are missing
constexpr double kMostPastPath_s = 0.15;  // half a sweep more than the limit of extrapolation

/// A picture or a sweep.
struct Recording {
  fs::path file;
  std::size_t frame = 0;
  FrameSpan span;
};

std::string find_sequence(const Kitti360Options& options) {
  if (!options.sequence.empty()) return options.sequence;
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(options.root / "data_poses", error)) {
    if (is_there(entry.path() / "poses.txt")) found.push_back(entry.path().filename().string());
  }
  std::sort(found.begin(), found.end());
  if (found.size() == 1) return found.front();
  throw_input_error((options.root / "data_poses").string(),
                    "sequences",
                    found.empty() ? "none" : fmt::format("{}", fmt::join(found, ", ")),
                    found.empty() ? "at least one" : "one of them as --sequence");
}

/// Requires a time for every frame: a blank line would shift the times of later frames.
std::vector<std::int64_t> read_times(const fs::path& file) {
  std::vector<std::int64_t> times = kitti::read_timestamps_ns(file);
  const auto lines = kitti::numbered_lines(file);
  if (!lines.empty() && lines.back().first == lines.size()) return times;
  throw_input_error(file.string(), "lines", lines.empty() ? "none" : "blank ones", "a time in each");
}

/// Returns the existing camera folders.
std::vector<std::pair<std::string, fs::path>> find_cameras(const fs::path& pictures) {
  std::vector<std::pair<std::string, fs::path>> found;
  std::error_code ignored;
  for (const char* name : {"image_00", "image_01", "image_02", "image_03"}) {
    const bool rectified = std::string(name) < "image_02";
    const fs::path folder = pictures / name / (rectified ? "data_rect" : "data_rgb");
    if (fs::is_directory(folder, ignored)) found.emplace_back(name, folder);
  }
  return found;
}

class Sequence {
 public:
  Sequence(const Kitti360Options& options, Kitti360Report& report)
      : options_(options), report_(report), name_(find_sequence(options)) {
    velodyne_ns_ = read_times(points() / "timestamps.txt");
    last_ = std::min(options.last, velodyne_ns_.size() - 1);
    if (options.first > last_) {
      throw_input_error(points().string(),
                        "frames",
                        fmt::format("{} to {} of {}", options.first, last_, velodyne_ns_.size()),
                        "at least one");
    }
    start_ns_ = velodyne_ns_[options.first];
  }

  /// Returns world_from_velo around the frames; the world frame is the velodyne's at the first pose.
  [[nodiscard]] Trajectory path(const Pose& imu_from_velo) const {
    constexpr std::size_t kMargin = 2;
    const fs::path file = options_.root / "data_poses" / name_ / "poses.txt";
    std::vector<TimedPose> path;
    Pose world_from_theirs;
    for (const auto& [frame, theirs_from_imu] : read_poses(file)) {
      if (frame + kMargin < options_.first || frame > last_ + kMargin || frame >= velodyne_ns_.size())
        continue;
      const Pose theirs_from_velo = theirs_from_imu * imu_from_velo;
      if (path.empty()) world_from_theirs = theirs_from_velo.inverse();
      path.push_back({seconds(velodyne_ns_[frame]), world_from_theirs * theirs_from_velo});
    }
    if (path.empty()) throw_input_error(file.string(), "poses of these frames", "none", "at least one");
    return with_context("reading " + file.string(), [&] { return Trajectory(std::move(path)); });
  }

  [[nodiscard]] std::vector<Recording> sweeps(const Trajectory& path) const {
    std::vector<double> stamps_s;
    for (const std::int64_t ns : velodyne_ns_) stamps_s.push_back(seconds(ns));
    return present(
        points() / "data", ".bin", path, sweep_spans(stamps_s, kRevolution_s, SweepStamp::kMiddle));
  }
  [[nodiscard]] std::vector<Recording> pictures(const fs::path& folder, const Trajectory& path) const {
    std::vector<FrameSpan> spans;
    for (const std::int64_t ns : read_times(folder.parent_path() / "timestamps.txt"))
      spans.push_back({seconds(ns), seconds(ns)});
    return present(folder, ".png", path, spans);
  }
  [[nodiscard]] std::vector<std::pair<std::string, fs::path>> cameras() const {
    return find_cameras(options_.root / "data_2d_raw" / name_);
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::int64_t start_ns() const { return start_ns_; }

 private:
  [[nodiscard]] fs::path points() const { return options_.root / "data_3d_raw" / name_ / "velodyne_points"; }
  [[nodiscard]] double seconds(std::int64_t ns) const { return static_cast<double>(ns - start_ns_) * 1e-9; }

  /// Returns the existing files of the frames that are close enough to a pose.
  [[nodiscard]] std::vector<Recording> present(const fs::path& folder,
                                               const char* ending,
                                               const Trajectory& path,
                                               const std::vector<FrameSpan>& spans) const {
    std::vector<Recording> found;
    std::error_code ignored;
    for (std::size_t frame = options_.first; frame <= last_; ++frame) {
      const fs::path file = folder / fmt::format("{:010}{}", frame, ending);
      if (frame >= spans.size() || !fs::exists(file, ignored)) {
        ++report_.absent;
        continue;
      }
      const double time_s = 0.5 * (spans[frame].time_start_s + spans[frame].time_end_s);
      if (time_s < path.start_s() - kMostPastPath_s || time_s > path.end_s() + kMostPastPath_s) {
        ++report_.unposed;
        continue;
      }
      found.push_back({file, frame, spans[frame]});
    }
    return found;
  }

  const Kitti360Options& options_;
  Kitti360Report& report_;
  std::string name_;
  std::vector<std::int64_t> velodyne_ns_;
  std::size_t last_ = 0;
  std::int64_t start_ns_ = 0;
};

}  // namespace

Log import_kitti360(const Kitti360Options& options, const FrameProgress& progress, Kitti360Report& report) {
  const Sequence sequence(options, report);
  const auto cameras = sequence.cameras();
  std::vector<std::string> names;
  for (const auto& [name, folder] : cameras) names.push_back(name);
  Calibration calibration = read_calibration(options.root / "calibration", names);

  Log log;
  log.name = name_from(sequence.name());
  log.start_ns = sequence.start_ns();
  log.cameras = std::move(calibration.cameras);
  log.world_from_rig = sequence.path(calibration.imu_from_velo);
  const std::vector<Recording> sweeps = sequence.sweeps(log.world_from_rig);
  std::vector<std::vector<Recording>> pictures;
  std::size_t total = sweeps.size();
  for (const auto& [name, folder] : cameras) {
    pictures.push_back(sequence.pictures(folder, log.world_from_rig));
    total += pictures.back().size();
  }
  if (total == 0) throw_nothing_left(options.root.string(), "pictures and sweeps", "none", "at least one");
  if (!sweeps.empty()) {
    std::vector<fs::path> files;
    for (const Recording& sweep : sweeps) files.push_back(sweep.file);
    log.lidars = {
        {kitti::fit_lidar(files, kitti::read_beam_table(options.lidar, kRevolution_s), report.points),
         Pose{}}};  // the rig's frame is the velodyne's
  }

  return make_import(options.output, log, [&] {
    LogMaker maker(log, progress, total);
    for (const Recording& sweep : sweeps) {
      const Lidar& lidar = log.lidars[0].with_rows();
      maker.add_sweep(lidar.name,
                      fmt::format("{:010}", sweep.frame),
                      kitti::read_sweep_file(sweep.file, lidar, report.points),
                      sweep.span);
      maker.step();
    }
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      for (const Recording& picture : pictures[c]) {
        const std::string stem = fmt::format("{}_{:010}", names[c], picture.frame);
        maker.add_picture(log.cameras[c].model, stem, picture.file, "calibration", picture.span);
        maker.step();
      }
    }
  });
}

}  // namespace simuli
