#pragma once
// Parts of the KITTI raw importer: text files, calibration, poses, sweeps. For io/import/kitti/*.cpp and tests.
#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/actor.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar.hpp"
#include "host/core/sensors/trajectory.hpp"
#include "io/log/label_tracks.hpp"
#include "io/log/log.hpp"

namespace simuli {
struct KittiReport;
}  // namespace simuli

namespace simuli::kitti {

// ---- text (kitti_text.cpp) ----

/// Parses one "YYYY-MM-DD HH:MM:SS[.fraction]" per line to nanoseconds since 1970; no value for blank lines
/// (lost sweeps). Throws Error{kInput} naming the line.
[[nodiscard]] std::vector<std::optional<std::int64_t>> read_lines_ns(const std::filesystem::path& file);
/// Removes times outside the longest increasing sequence and returns their indices.
[[nodiscard]] std::vector<std::size_t> take_disordered(std::vector<std::optional<std::int64_t>>& times_ns);
/// read_lines_ns() without the blank lines.
[[nodiscard]] std::vector<std::int64_t> read_timestamps_ns(const std::filesystem::path& file);
/// Parses "key: value" lines. Throws Error{kInput} for a line without a key and for a repeated key.
[[nodiscard]] std::map<std::string, std::string> read_key_lines(const std::filesystem::path& file);
/// Returns the non-blank lines with their numbers from 1, without line ends (either kind).
[[nodiscard]] std::vector<std::pair<std::size_t, std::string>> numbered_lines(
    const std::filesystem::path& file);
/// Parses exactly `count` finite numbers separated by blanks. Throws Error{kInput} naming file and field
/// otherwise.
[[nodiscard]] std::vector<double> parse_numbers(const std::string& text,
                                                std::size_t count,
                                                const std::filesystem::path& file,
                                                const std::string& field);

// ---- calibration (kitti_calib.cpp) ----

struct Calibration {
  /// As rectified: ideal pinholes with a global shutter, each offset by its baseline from camera 0; the rig's
  /// frame is the velodyne's.
  std::vector<LogCamera> cameras;
  Pose velo_from_imu;
  Pose rect00_from_velo;  // rectified frame of camera 0, the frame of labelled boxes
};

/// Reads calib_cam_to_cam.txt, calib_velo_to_cam.txt, and, for poses from oxts, calib_imu_to_velo.txt of the
/// date's folder, for `cameras` such as "image_02". Throws Error{kInput} for a missing key, a wrong number of
/// values, and a matrix that is not a rotation.
[[nodiscard]] Calibration read_calibration(const std::filesystem::path& date_folder,
                                           bool with_imu,
                                           const std::vector<std::string>& cameras);

// ---- poses (kitti_poses.cpp) ----

/// Frame numbers, inclusive.
struct Frames {
  std::size_t first = 0;
  std::size_t last = 0;
  [[nodiscard]] bool has(std::size_t frame) const { return frame >= first && frame <= last; }
  /// Returns the range extended by `margin` at both ends.
  [[nodiscard]] Frames with_margin(std::size_t margin) const {
    const std::size_t most = std::numeric_limits<std::size_t>::max();
    return {first - std::min(first, margin), last > most - margin ? most : last + margin};
  }
};

/// Poses before and after a part of a drive that its trajectory includes.
inline constexpr std::size_t kPathMargin = 2;

/// One oxts record: the pose of the IMU.
struct GeodeticPose {
  double latitude_rad = 0.0;
  double longitude_rad = 0.0;
  double altitude_m = 0.0;
  double roll_rad = 0.0;   // 0 level, positive: left side up
  double pitch_rad = 0.0;  // 0 level, positive: front down
  double yaw_rad = 0.0;    // 0 east, counter-clockwise
};

/// Returns ecef_from_imu on the WGS 84 ellipsoid: exact at any distance, whereas map projections have scale
/// errors.
[[nodiscard]] Pose ecef_from_imu(const GeodeticPose& pose);

/// Returns world_from_velo at the oxts times of the frames, and of up to `beside` frames around them if they
/// exist; the world frame is the velodyne's at the first pose. Seconds count from start_ns. Frames without a
/// record are added to `absent`, frames with times out of order to `disordered`.
[[nodiscard]] Trajectory read_oxts(const std::filesystem::path& drive,
                                   const Frames& frames,
                                   const Frames& beside,
                                   const Pose& velo_from_imu,
                                   std::int64_t start_ns,
                                   std::vector<std::size_t>& absent,
                                   std::vector<std::size_t>& disordered);

/// Returns world_from_velo at t_sweep_forward (seconds of the day) from a pose file, for those of `frames` that
/// it contains; the date is that of `forward_ns`, the recorded times of the sweeps, from which t_sweep_forward
/// must differ by less than a second.
[[nodiscard]] Trajectory read_pose_file(const std::filesystem::path& file,
                                        const std::vector<std::int64_t>& forward_ns,
                                        std::int64_t start_ns,
                                        const Frames& frames);

// ---- boxes (kitti_tracking.cpp) ----

/// Start and end of the frames' sweeps in s, and the velodyne's trajectory.
struct SweepTimes {
  std::vector<double> start_s, end_s;
  Trajectory world_from_velo;
  std::size_t first = 0;  // frame number of the first sweep
};

/// Returns the labelled objects of the frames, except "DontCare", in the order of their track ids, named
/// "car_3". A box has the pose at the time at which the LiDAR scanned its centre. Leaves out other frames.
/// Throws Error{kInput} with file and line for lines without the 17 columns of a label.
[[nodiscard]] std::vector<Actor> read_tracking(const std::filesystem::path& file,
                                               const Pose& rect00_from_velo,
                                               const SweepTimes& sweeps,
                                               LabelReport& report);

// ---- sweeps (kitti_sweep.cpp) ----

struct Point {
  Eigen::Vector3d position;  // m, velodyne frame at the point's own time
  double reflectance = 0.0;  // [0, 1]
};

/// Reads float32 x y z reflectance. Throws Error{kInput} for a size that is not a multiple of 16, NaN, Inf, and
/// a reflectance outside [0, 1]; with `needs_places` any reflectance is allowed.
[[nodiscard]] std::vector<Point> read_points(const std::filesystem::path& file, bool needs_places = false);

/// A sweep's points by beam.
struct BeamPoints {
  std::vector<std::vector<Point>> rows;  // by beam of the Lidar, in firing order
  std::size_t unplaced = 0;              // points assigned to no beam
  std::size_t ring_agrees = 0;           // assigned points whose ring in the file is their beam's
};

/// Assigns points by elevation as seen from each beam's own origin, and compares with the rings of the file.
[[nodiscard]] BeamPoints sort_into_beams(const std::vector<Point>& points, const Lidar& lidar);

/// Returns the firings per revolution, from the spacing of neighbouring points; 0 for too few points.
[[nodiscard]] double estimate_columns(const BeamPoints& beams, const Lidar& lidar);

/// Returns the grid column of each azimuth in [0, columns): strictly increasing, the least-squares fit to a
/// uniform rotation. `azimuths_rad`: of one beam in firing order (clockwise from pi), at most `columns` of
/// them.
[[nodiscard]] std::vector<int> assign_columns(const std::vector<double>& azimuths_rad, int columns);

/// Returns the full firing grid: measured rays as seen from their beam's origin; all others with range 0, the
/// beam's elevation, and azimuths interpolated between their neighbours.
[[nodiscard]] Sweep make_sweep(const BeamPoints& beams, const Lidar& lidar);

// ---- the sensor of a drive (kitti_drive.cpp) ----

/// Returns the beam table of the sweeps. Files are cut at a point azimuth of pi: beams with an azimuth offset fire
/// there at another time, which the log's grid stores as a time offset. A revolution takes sweep_s.
[[nodiscard]] Lidar read_beam_table(const std::filesystem::path& file, double sweep_s);

/// Returns the model with the firings per revolution and the range limits of these sweeps, whose points are counted
/// in the report. Throws Error{kInput} if more than 0.5 % of a sweep's points are on no beam, and if the number of
/// firings differs by more than 4 % from the table's.
[[nodiscard]] Lidar fit_lidar(const std::vector<std::filesystem::path>& files,
                              Lidar lidar,
                              KittiReport& report);

/// Returns make_sweep() of a file and adds it to the report.
[[nodiscard]] Sweep read_sweep_file(const std::filesystem::path& file,
                                    const Lidar& lidar,
                                    KittiReport& report);

}  // namespace simuli::kitti
