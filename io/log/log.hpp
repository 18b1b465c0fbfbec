#pragma once
// Log folders: log.json (sensors, trajectory, frames, actors; units in the key names), images/, sweeps/.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/actor.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/core/sensors/trajectory.hpp"

namespace simuli {

/// Called after every frame with the number of frames done and their total.
using FrameProgress = std::function<void(std::size_t, std::size_t)>;

struct LogCamera {
  Camera model;
  Pose rig_from_camera;
};

struct LogLidar {
  LidarModel model;
  Pose rig_from_lidar;

  /// Returns the model as a grid of rows and columns. Error{kInput} for a ray list.
  [[nodiscard]] const Lidar& with_rows() const;
};

/// One recorded picture, exposed from start to end; both times are equal for a global shutter.
struct ImageFrame {
  std::string camera;  // name of a LogCamera
  std::string file;    // relative to the log folder
  double time_start_s = 0.0;
  double time_end_s = 0.0;
};

/// One recorded sweep. Its file stores the full firing grid, or for a ray list one row of all rays in their order.
struct SweepFrame {
  std::string lidar;  // name of a LogLidar
  std::string file;   // relative to the log folder
  double time_start_s = 0.0;
  double time_end_s = 0.0;
};

struct CameraMask;  // camera_mask.hpp
class FrameFiles;   // frame_files.hpp

/// A mask picture for all pictures of one camera, which hides the ego vehicle's hood or a frame. Pixels whose first
/// channel is not 0 are left out of training and evaluation.
struct LogMask {
  std::string camera;  // name of a LogCamera; it may have several masks
  std::string file;    // relative to the log folder
};

struct Log {
  std::filesystem::path folder;
  std::string name;
  std::int64_t start_ns = 0;  // epoch of all seconds below
  std::vector<LogCamera> cameras;
  std::vector<LogLidar> lidars;
  Trajectory world_from_rig;
  std::vector<ImageFrame> images;  // in time order
  std::vector<SweepFrame> sweeps;  // in time order
  std::vector<Actor> actors;       // boxes of moving objects, with their tracks
  /// PLY file of points in the world, m, relative to the log folder, from structure from motion: initialisation places
  /// particles at them, in addition to LiDAR returns. Empty: none.
  std::string points = {};
  std::vector<LogMask> masks = {};
  /// The union of each camera's masks, by camera, as read_masks() reads them.
  std::map<std::string, std::shared_ptr<const CameraMask>> hidden = {};
  /// Cache of the frames; null: no cache.
  std::shared_ptr<FrameFiles> files = {};

  [[nodiscard]] const LogCamera& camera(const std::string& camera_name) const;  // Error{kInput}
  [[nodiscard]] const LogLidar& lidar(const std::string& lidar_name) const;     // Error{kInput}
};

/// The rays of a sweep and their returns, row-major rows x columns. A ray without a return has range 0 and intensity 0,
/// and keeps the direction and time at which it was fired.
struct Sweep {
  LidarRays rays;
  std::vector<float> range;      // [rows*columns] m from the ray's own origin, distances; 0: no return
  std::vector<float> intensity;  // [rows*columns] in [0, 1]
};

/// Returns the log with the rig on another trajectory. Boxes of actors were labelled relative to the rig and move with it.
[[nodiscard]] Log on_path(Log log, const Trajectory& world_from_rig);

/// Sorts pictures and sweeps by start time (stable).
void sort_by_time(Log& log);

/// Reads the mask pictures of log.masks into log.hidden, for load_image(). Error{kInput} as read_camera_mask().
void read_masks(Log& log);
/// Reads log.json and masks. A LiDAR's revolution takes the median duration of its sweeps. Error{kInput} for unknown and
/// missing keys, wrong types or units, and names of absent sensors.
[[nodiscard]] Log read_log(const std::filesystem::path& folder);
/// Writes log.json (temporary name, sync, rename) alone, without pictures and sweeps.
void write_log(const Log& log);
/// Writes a changed log as a new folder, complete or not at all, and returns it as read_log() reads it. Pictures,
/// sweeps, points and masks become hard links where the file system supports them, else copies. `files` maps names in
/// the log to files elsewhere that are copied instead. Error{kInput} if the folder exists.
Log copy_log(const Log& log,
             const std::filesystem::path& folder,
             const std::map<std::string, std::filesystem::path>& files = {});
/// Returns a hash of a log, 16 hexadecimal digits: of the values in log.json and of the sizes of the files that it
/// names. The location of the folder and the layout of log.json have no influence.
[[nodiscard]] std::string log_hash(const Log& log);

/// Sweeps are multi-channel float OpenEXR pictures (rows x columns; channels range_m, intensity,
/// azimuth_rad, elevation_rad, time_fraction), lossless, readable by any EXR tool. The file holds ranges as recorded;
/// read_sweep() subtracts the range biases of the rows.
[[nodiscard]] Sweep read_sweep(const std::filesystem::path& file, const LidarModel& lidar);
void write_sweep(const std::filesystem::path& file, const Sweep& sweep);

/// Copies a picture file unchanged into a log after checking that it decodes to the camera's size. Error{kInput}
/// otherwise; `source` names the origin of the camera's size.
void copy_picture(const std::filesystem::path& from,
                  const std::filesystem::path& to,
                  const Camera& camera,
                  const std::string& source);

}  // namespace simuli
