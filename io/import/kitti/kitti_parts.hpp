#pragma once
// The parts of the KITTI raw importer: text files, calibration, poses, sweeps. For io/kitti*.cpp and tests.
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

/// One "YYYY-MM-DD HH:MM:SS[.fraction]" per line as nanoseconds since 1970, none where the line is blank, as
/// for sweeps that were lost; Error{kInput} names the line.
[[nodiscard]] std::vector<std::optional<std::int64_t>> read_lines_ns(const std::filesystem::path& file);
/// Takes away what is not in the longest sequence of rising times, and returns the places where it stood.
[[nodiscard]] std::vector<std::size_t> take_disordered(std::vector<std::optional<std::int64_t>>& times_ns);
/// read_lines_ns() without the blank lines.
[[nodiscard]] std::vector<std::int64_t> read_timestamps_ns(const std::filesystem::path& file);
/// "key: value" lines. Error{kInput} for a line without a key and for a key that stands twice.
[[nodiscard]] std::map<std::string, std::string> read_key_lines(const std::filesystem::path& file);
/// Lines that are not blank with their numbers from 1, without their line end (either kind).
[[nodiscard]] std::vector<std::pair<std::size_t, std::string>> numbered_lines(
    const std::filesystem::path& file);
/// Exactly `count` finite numbers parted by blanks; Error{kInput} naming file and field otherwise.
[[nodiscard]] std::vector<double> parse_numbers(const std::string& text,
                                                std::size_t count,
                                                const std::filesystem::path& file,
                                                const std::string& field);

// ---- calibration (kitti_calib.cpp) ----

struct Calibration {
  /// As rectified: ideal pinholes with a global shutter, each its baseline off camera 0; the rig is the
  /// velodyne.
  std::vector<LogCamera> cameras;
  Pose velo_from_imu;
  Pose rect00_from_velo;  // the rectified frame of camera 0, in which boxes are labelled
};

/// From the folder of the date: calib_cam_to_cam.txt, calib_velo_to_cam.txt, and calib_imu_to_velo.txt when
/// poses come from oxts; of `cameras`, as "image_02". Error{kInput} for a missing key, a wrong count, a
/// matrix that is no rotation.
[[nodiscard]] Calibration read_calibration(const std::filesystem::path& date_folder,
                                           bool with_imu,
                                           const std::vector<std::string>& cameras);

// ---- poses (kitti_poses.cpp) ----

/// Numbers of frames, both ends among them.
struct Frames {
  std::size_t first = 0;
  std::size_t last = 0;
  [[nodiscard]] bool has(std::size_t frame) const { return frame >= first && frame <= last; }
  /// With so many more at either end.
  [[nodiscard]] Frames with_margin(std::size_t margin) const {
    const std::size_t most = std::numeric_limits<std::size_t>::max();
    return {first - std::min(first, margin), last > most - margin ? most : last + margin};
  }
};

/// Poses beside a part of a drive that belong to its path, too.
inline constexpr std::size_t kPathMargin = 2;

/// One oxts record: where the IMU was.
struct GeodeticPose {
  double latitude_rad = 0.0;
  double longitude_rad = 0.0;
  double altitude_m = 0.0;
  double roll_rad = 0.0;   // 0 level, positive: left side up
  double pitch_rad = 0.0;  // 0 level, positive: front down
  double yaw_rad = 0.0;    // 0 east, counter-clockwise
};

/// ecef_from_imu on the WGS 84 ellipsoid: exact at any distance, where a map projection is off by 0.2 %.
[[nodiscard]] Pose ecef_from_imu(const GeodeticPose& pose);

/// world_from_velo at the oxts timestamps of the frames' records, and of those up to `beside` where they are
/// there; world is the velodyne frame at the first. Seconds count from start_ns. Of the frames, those without
/// a record become `absent`, those whose times are out of order `disordered`.
[[nodiscard]] Trajectory read_oxts(const std::filesystem::path& drive,
                                   const Frames& frames,
                                   const Frames& beside,
                                   const Pose& velo_from_imu,
                                   std::int64_t start_ns,
                                   std::vector<std::size_t>& absent,
                                   std::vector<std::size_t>& disordered);

/// world_from_velo at t_sweep_forward (seconds of day) from a pose file, of the frames that it has among
/// `frames`; the date comes from `forward_ns`, the recorded time of each sweep of the drive, which
/// t_sweep_forward has to meet within a second.
[[nodiscard]] Trajectory read_pose_file(const std::filesystem::path& file,
                                        const std::vector<std::int64_t>& forward_ns,
                                        std::int64_t start_ns,
                                        const Frames& frames);

// ---- boxes (kitti_tracking.cpp) ----

/// Start and end of each sweep of the frames, s, and where the velodyne was.
struct SweepTimes {
  std::vector<double> start_s, end_s;
  Trajectory world_from_velo;
  std::size_t first = 0;  // the frame of the first of them
};

/// The labelled objects of those frames, "DontCare" excepted, in the order of their track ids and named
/// "car_3". A box is where the laser met it: its pose counts for the time at which the spin passed its
/// middle. Frames beyond are left out. Error{kInput} with file and line for anything but the 17 columns of a
/// label.
[[nodiscard]] std::vector<Actor> read_tracking(const std::filesystem::path& file,
                                               const Pose& rect00_from_velo,
                                               const SweepTimes& sweeps,
                                               LabelReport& report);

// ---- sweeps (kitti_sweep.cpp) ----

struct Point {
  Eigen::Vector3d position;  // m, velodyne frame at the point's own time
  double reflectance = 0.0;  // [0, 1]
};

/// float32 x y z reflectance. Error{kInput} for a size that is no multiple of 16, NaN, Inf, a reflectance
/// outside [0, 1]; who `needs_places` alone takes any reflectance.
[[nodiscard]] std::vector<Point> read_points(const std::filesystem::path& file, bool needs_places = false);

/// A sweep's points sorted into the beams that fired them.
struct BeamPoints {
  std::vector<std::vector<Point>> rows;  // of the Lidar, each in firing order
  std::size_t unplaced = 0;              // points that belong to no beam
  std::size_t ring_agrees = 0;           // placed points whose ring in the file is their beam's too
};

/// By elevation seen from each beam's own origin, checked against the rings in which the points stand.
[[nodiscard]] BeamPoints sort_into_beams(const std::vector<Point>& points, const Lidar& lidar);

/// Firings per turn, from the spacing of neighbouring points; 0 when there are too few to tell.
[[nodiscard]] double estimate_columns(const BeamPoints& beams, const Lidar& lidar);

/// Grid column of each azimuth in [0, columns): strictly increasing, the least squares fit to where a
/// perfectly even spin would have it. `azimuths_rad`: one beam in firing order (clockwise from pi), at most
/// `columns` of them.
[[nodiscard]] std::vector<int> assign_columns(const std::vector<double>& azimuths_rad, int columns);

/// The full firing grid: measured rays as measured from their beam's origin, all others with the azimuth
/// between their neighbours, the beam's elevation, range 0.
[[nodiscard]] Sweep make_sweep(const BeamPoints& beams, const Lidar& lidar);

// ---- the sensor of a drive (kitti_drive.cpp) ----

/// The beam table to read the sweeps with. Files are cut where a point's own azimuth is pi, whichever beam it
/// came from: a beam that looks further round fires there later, which the log's grid tells as a time offset.
/// A turn takes sweep_s.
[[nodiscard]] Lidar read_beam_table(const std::filesystem::path& file, double sweep_s);

/// The model with the firings per turn of these sweeps and range limits that hold their points, which are
/// counted in the report. Error{kInput} when more than 0.5 % of a sweep's points are on no beam, or a turn
/// has over 4 % more or fewer firings than the table says.
[[nodiscard]] Lidar fit_lidar(const std::vector<std::filesystem::path>& files,
                              Lidar lidar,
                              KittiReport& report);

/// make_sweep() of a file, counted in the report.
[[nodiscard]] Sweep read_sweep_file(const std::filesystem::path& file, const Lidar& lidar, KittiReport& report);

}  // namespace simuli::kitti
