#pragma once
// A log folder: log.json (sensors, trajectory, frames, actors; units in the key names), images/, sweeps/.
#include <cstdint>
#include <filesystem>
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

struct LogCamera {
  Camera model;
  Pose rig_from_camera;
};

struct LogLidar {
  LidarModel model;
  Pose rig_from_lidar;

  /// The model where a firing grid is needed: Error{kInput} for a ray list.
  [[nodiscard]] const Lidar& with_rows() const;
};

/// One recorded image. Exposure from start to end: equal for a global shutter.
struct ImageFrame {
  std::string camera;  // name of a LogCamera
  std::string file;    // relative to the log folder
  double time_start_s = 0.0;
  double time_end_s = 0.0;
};

/// One recorded sweep, stored as the full firing grid; of a ray list as one row of its rays in their order.
struct SweepFrame {
  std::string lidar;  // name of a LogLidar
  std::string file;   // relative to the log folder
  double time_start_s = 0.0;
  double time_end_s = 0.0;
};

struct CameraMask;  // camera_mask.hpp
class FrameFiles;   // frame_files.hpp

/// A picture of what is never the scene in those of one camera: the vehicle's own hood, a frame. What is not
/// 0 in its first channel is neither learned from nor compared with.
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
  std::vector<ImageFrame> images;  // by time
  std::vector<SweepFrame> sweeps;  // by time
  std::vector<Actor> actors;       // boxes of what moves, with their tracks
  /// PLY of points in the world, m, relative to the log folder: where initialisation starts from beside
  /// LiDAR returns (structure from motion). Empty: none.
  std::string points = {};
  std::vector<LogMask> masks = {};
  /// By camera what its masks hide, as read_masks() found it.
  std::map<std::string, std::shared_ptr<const CameraMask>> hidden = {};
  /// Where frames are kept once read; null: nowhere.
  std::shared_ptr<FrameFiles> files = {};

  [[nodiscard]] const LogCamera& camera(const std::string& camera_name) const;  // Error{kInput}
  [[nodiscard]] const LogLidar& lidar(const std::string& lidar_name) const;     // Error{kInput}
};

/// Rays of a sweep with what came back, row-major rows x columns. A ray that returned nothing has
/// range 0 and intensity 0; its direction and time are those it was fired with.
struct Sweep {
  LidarRays rays;
  std::vector<float> range;      // [rows*columns] m from the ray's own origin, distances; 0: no return
  std::vector<float> intensity;  // [rows*columns] in [0, 1]
};

/// The log with the rig on another path. Boxes of actors were seen from the rig and go where it goes.
[[nodiscard]] Log on_path(Log log, const Trajectory& world_from_rig);

/// Pictures and sweeps in the order in which they began; what began at once stays as it was.
void sort_by_time(Log& log);

/// Reads the pictures that log.masks names, for load_image(). Error{kInput} as read_camera_mask().
void read_masks(Log& log);
/// Reads log.json and masks. LiDARs take as long for a turn as their sweeps did (the median). Unknown keys,
/// missing keys, wrong types or units, dangling names are Error{kInput}.
[[nodiscard]] Log read_log(const std::filesystem::path& folder);
/// Writes log.json (temporary name, sync, rename); images and sweeps are written by their writers.
void write_log(const Log& log);
/// The log with whatever was changed in it as a new folder, complete or not at all; as it is read there.
/// Pictures, sweeps, points and masks are hard links where the file system has them, copies where not.
/// `files` are copied from elsewhere, by their names in the log. Error{kInput} when the folder exists.
Log copy_log(const Log& log,
             const std::filesystem::path& folder,
             const std::map<std::string, std::filesystem::path>& files = {});
/// What a log is known by, 16 hexadecimal digits: of all that log.json says, and of the sizes in bytes of the
/// files that it names. Where the folder lies makes no difference, nor does how log.json is laid out.
[[nodiscard]] std::string log_hash(const Log& log);

/// Sweeps are multi-channel float OpenEXR pictures (rows x columns; channels range_m, intensity,
/// azimuth_rad, elevation_rad, time_fraction), lossless, readable by any EXR tool. The file holds ranges as
/// recorded; read_sweep takes the rows' range biases off.
[[nodiscard]] Sweep read_sweep(const std::filesystem::path& file, const LidarModel& lidar);
void write_sweep(const std::filesystem::path& file, const Sweep& sweep);

/// Copies a picture's own bytes into a log, once it is known that they decode to the camera's size; `source`
/// names what that size comes from. Error{kInput} otherwise.
void copy_picture(const std::filesystem::path& from,
                  const std::filesystem::path& to,
                  const Camera& camera,
                  const std::string& source);

}  // namespace simuli
