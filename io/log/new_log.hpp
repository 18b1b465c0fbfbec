#pragma once
// Making of log folders, which appear complete or not at all.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "io/log/frame_spans.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// Makes the folder `output` as write_folder_atomically() does. `fill()` writes pictures and sweeps below
/// log.folder, which has the folders images and sweeps then, and adds their frames to `log`; log.json is written after
/// that. Returns the log as read_log() reads it. Errors as write_folder_atomically(), read_log() and `fill`.
[[nodiscard]] Log make_log(const std::filesystem::path& output, Log& log, const std::function<void()>& fill);
/// make_log() for importers. Sorts the frames by time. Error{kNothing} if `fill()` adds neither pictures nor sweeps.
/// An empty `output` requests a survey: log.folder is empty, put_file() and LogMaker write nothing, and the log is
/// returned as `fill()` leaves it.
[[nodiscard]] Log make_import(const std::filesystem::path& output,
                              Log& log,
                              const std::function<void()>& fill);

/// Calls `write(path)` for the file of that name in the log, whose folder is created before. Does nothing in a survey.
void put_file(const Log& log,
              const std::string& file,
              const std::function<void(const std::filesystem::path&)>& write);
/// Hides the lowest `share` of all pictures of a camera, which show the vehicle there. Returns a line that reports
/// it; no line if the log has no pictures of that camera.
[[nodiscard]] std::vector<std::string> hide_lowest(Log& log, const std::string& camera, double share);

/// Adds frames to a log within make_import(): writes their files, counts the rays and reports the progress.
class LogMaker {
 public:
  /// `total` is the number of step() calls to come.
  LogMaker(Log& log, FrameProgress progress, std::size_t total)
      : log_(log), progress_(std::move(progress)), total_(total) {}

  /// Writes a sweep as "sweeps/STEM.exr".
  void add_sweep(const std::string& lidar,
                 const std::string& stem,
                 const Sweep& sweep,
                 const FrameSpan& span);
  /// Copies a picture to "images/STEM" with the ending of `from`. `source` names the origin of the camera's size in
  /// errors, which are those of copy_picture().
  void add_picture(const Camera& camera,
                   const std::string& stem,
                   const std::filesystem::path& from,
                   const std::string& source,
                   const FrameSpan& span);
  /// Reports one more step as done.
  void step();

  [[nodiscard]] std::size_t rays() const { return rays_; }  // of all sweeps added
  [[nodiscard]] std::size_t returned() const { return returned_; }

 private:
  Log& log_;
  FrameProgress progress_;
  std::size_t done_ = 0, total_, rays_ = 0, returned_ = 0;
};

/// The instant of a sweep that its time stamp refers to.
enum class SweepStamp { kStart, kMiddle, kEnd };

/// Start and end of each sweep of a spinning LiDAR from rising time stamps: a sweep reaches to its neighbour, or lasts
/// one revolution where the neighbour is missing or at least 1.5 revolutions away.
[[nodiscard]] std::vector<FrameSpan> sweep_spans(const std::vector<double>& stamps_s,
                                                 double revolution_s,
                                                 SweepStamp stamp);

/// Returns the sensors that the user requests, in the order of `known`; all of them if `requested` is empty.
/// Error{kUsage} that begins with `option` for an unknown name.
[[nodiscard]] std::vector<std::string> requested_sensors(const std::vector<std::string>& requested,
                                                         const std::vector<std::string>& known,
                                                         const char* option);

}  // namespace simuli
