#include "io/import/ros2/ros2_log.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/linear_algebra.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/spread.hpp"
#include "io/import/ros2/ros2_frames.hpp"
#include "io/import/ros2/ros2_lidar.hpp"
#include "io/import/ros2/ros2_scan.hpp"
#include "io/log/new_log.hpp"
#include "io/ros2/camera_info.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace ros2;  // NOLINT(google-build-using-namespace): the import uses all of them

constexpr double kNanosecond_s = 1e-9;

/// "/a/b/c" -> "/a/b"; for a picture compressed by a transport, that of the picture.
std::string folder_of(std::string topic) {
  constexpr std::string_view kTransport = "/compressed";
  if (topic.ends_with(kTransport)) topic.resize(topic.size() - kTransport.size());
  return topic.substr(0, topic.rfind('/') == std::string::npos ? 0 : topic.rfind('/'));
}

template <class Map>
std::string names(const Map& topics) {
  std::string all;
  for (const auto& [name, unused] : topics) all += (all.empty() ? "" : ", ") + name;
  return all.empty() ? "none" : all;
}

class Importer {
 public:
  Importer(const Ros2Options& options, Ros2Report& report)
      : options_(options),
        report_(report),
        file_(options.recording.string()),
        bag_(open_bag(options.recording)),
        scan_(scan_bag(*bag_, options)) {}

  Log run(const FrameProgress& progress) {
    if (options_.output.empty()) return survey();
    choose();
    return make_import(options_.output, log_, [&] {
      FrameWriter writer(*bag_, file_, log_, span_, report_);
      for (const auto& [topic, unused] : lidars_) writer.total += scan_.clouds.at(topic).stamps_ns.size();
      for (const auto& [topic, unused] : cameras_) writer.total += scan_.pictures.at(topic).stamps_ns.size();
      writer.write(lidars_, cameras_, field_options(options_), progress);
      if (log_.images.empty() && log_.sweeps.empty()) need_common_clock();
      need_placed(report_.points, file_);
    });
  }

 private:
  /// Validates the request before frames are read.
  void choose() {
    for (const auto& [option, topics] :
         {std::pair("--topics", options_.topics), std::pair("--ignore", options_.ignore)}) {
      for (const std::string& topic : topics) {
        if (scan_.topics.count(topic) == 0)
          refuse_option(option, topic, fmt::format("a topic of it: {}", fmt::join(scan_.topics, ", ")));
      }
    }
    if (scan_.bad_transforms > 0)
      note(fmt::format("left out: {} transforms and poses that are none (NaN, or no unit quaternion)",
                       scan_.bad_transforms));
    for (const std::string& frame : scan_.transforms.ambiguous())
      note("frame " + frame +
           " has several parents: the one that leads to --world-frame, else the newest is taken");
    choose_lidars();
    choose_cameras();
    for (const auto& [topic, damage] : scan_.damaged) {  // FrameWriter reports the others
      if (lidars_.count(topic) == 0 && cameras_.count(topic) == 0)
        note(fmt::format("left out: {} messages of {}: {}", damage.count, topic, damage.first));
    }
    if (lidars_.empty() && cameras_.empty()) {
      const std::string why = fmt::format("{}", fmt::join(report_.notes, "; "));
      throw_nothing_left(
          file_, "sensors", why.empty() ? "no clouds and no pictures" : why, "at least one sensor");
    }
    find_path();
  }

  /// Reports why no frame is within the trajectory.
  [[noreturn]] void need_common_clock() const {
    const auto [first_s, last_s] = frames_s_;
    throw_nothing_left(
        file_,
        "stamps of clouds and pictures",
        fmt::format("{:.3f} to {:.3f} s, none on the path", first_s, last_s),
        fmt::format("within the path's {:.3f} to {:.3f} s: one clock for all (sensors often count "
                    "from when they were switched on; PTP or their driver sets them)",
                    static_cast<double>(span_.first) * kNanosecond_s,
                    static_cast<double>(span_.second) * kNanosecond_s));
  }

  /// Lists the topics, their interpretation, and the log without files; for refused recordings the reason, and
  /// an empty log.
  Log survey() {
    const auto tell = [&](const char* kind, const std::string& topic, const SensorTopic& t) {
      const auto [first, last] = std::minmax_element(t.stamps_ns.begin(), t.stamps_ns.end());
      const double apart = apart_s(t);
      note(fmt::format("{} {}: {} messages{}, {:.3f} to {:.3f} s, frame {}",
                       kind,
                       topic,
                       t.stamps_ns.size(),
                       apart > 0.0 ? fmt::format(", {:.4g} Hz", 1.0 / apart) : "",
                       static_cast<double>(*first) * kNanosecond_s,
                       static_cast<double>(*last) * kNanosecond_s,
                       t.frame_id));
    };
    for (const auto& [topic, cloud] : scan_.clouds) tell("clouds", topic, cloud);
    for (const auto& [topic, picture] : scan_.pictures) tell("pictures", topic, picture);
    for (const auto& [topic, poses] : scan_.odometry)
      note(fmt::format("odometry {}: {} messages", topic, poses.size()));
    note("frames: " + scan_.transforms.frames());
    try {
      choose();
      FrameWriter(*bag_, file_, log_, span_, report_).survey(scan_, lidars_, cameras_);
      if (log_.images.empty() && log_.sweeps.empty()) need_common_clock();
      sort_by_time(log_);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::kUsage) throw;
      note(fmt::format("refused: {}", error.what()));
      return {};
    }
    return log_;
  }

  void note(std::string text) { report_.notes.push_back(std::move(text)); }

  [[noreturn]] static void refuse_option(const char* option,
                                         const std::string& found,
                                         const std::string& allowed) {
    throw Error(ErrorKind::kUsage, fmt::format("{}: found \"{}\", allowed {}", option, found, allowed));
  }

  /// Returns the topic's parent, or the whole topic if another sensor has that name.
  std::string name_of_topic(const std::string& topic) {
    const std::string folder = folder_of(topic);
    for (std::string name : {folder.empty() ? topic : folder, topic}) {
      name.erase(0, name.find_first_not_of('/'));
      std::replace(name.begin(), name.end(), '/', '_');
      name = name_from(name.empty() ? "sensor" : name);
      if (names_.insert(name).second) return name;
    }
    throw_input_error(file_, topic, "a name that two sensors would have", "topics that differ");
  }

  /// Throws Error{kInput} for a topic without a valid message.
  void need_sound(const std::string& topic) const {
    const auto damage = scan_.damaged.find(topic);
    if (damage != scan_.damaged.end()) throw Error(ErrorKind::kInput, damage->second.first);
  }

  /// Returns rig_from_sensor of a camera or a LiDAR.
  Pose mount_of(const std::string& topic, const std::string& frame, bool is_camera) const {
    const auto requested = options_.mounts.find(topic);
    if (requested != options_.mounts.end())
      return is_camera ? requested->second.rig_from_camera() : requested->second.rig_from_lidar();
    return fixed(options_.rig_frame, frame, topic);
  }

  /// Returns a_from_b of frames without relative motion.
  [[nodiscard]] Pose fixed(const std::string& a, const std::string& b, const std::string& topic) const {
    const auto pose = scan_.transforms.fixed(a, b);
    if (!pose) {
      throw_input_error(
          file_,
          fmt::format("transform of {} ({}) in {}", b, topic, a),
          fmt::format("none; frames: {}", scan_.transforms.frames()),
          fmt::format("one that stays, --rig-frame FRAME, or --mount {}:X,Y,Z,ROLL,PITCH,YAW", topic));
    }
    return *pose;
  }

  /// Returns the median time between messages; 0 for a single one.
  static double apart_s(const SensorTopic& topic) {
    std::vector<std::int64_t> steps;
    std::vector<std::int64_t> stamps = topic.stamps_ns;
    std::sort(stamps.begin(), stamps.end());
    for (std::size_t i = 1; i < stamps.size(); ++i) {
      if (stamps[i] > stamps[i - 1]) steps.push_back(stamps[i] - stamps[i - 1]);
    }
    return static_cast<double>(upper_median(std::move(steps))) * kNanosecond_s;
  }

  void choose_lidars() {
    const auto stamp = options_.stamp == "start" ? Stamp::kStart
                       : options_.stamp == "end" ? Stamp::kEnd
                                                 : Stamp::kUnknown;
    if (!options_.stamp.empty() && stamp == Stamp::kUnknown)
      refuse_option("--stamp", options_.stamp, "start, end");
    if (options_.lidars.empty() && !options_.without_lidars && !scan_.clouds.empty()) {
      throw_input_error(file_,
                        "clouds",
                        names(scan_.clouds),
                        "--lidar TOPIC=SENSOR for those that are wanted (simuli info sensors; simuli fit "
                        "beams), or --no-lidars");
    }
    for (const Ros2Lidar& requested : options_.lidars) {
      const auto found = scan_.clouds.find(requested.topic);
      if (found == scan_.clouds.end()) {
        need_sound(requested.topic);
        refuse_option("--lidar", requested.topic, "a topic of clouds: " + names(scan_.clouds));
      }
      const SensorTopic& topic = found->second;
      if (!topic.fields && !topic.unreadable.empty()) throw Error(ErrorKind::kInput, topic.unreadable);
      const std::string& frame = requested.frame.empty() ? topic.frame_id : requested.frame;
      const Pose table_from_cloud = fixed(frame, topic.frame_id, requested.topic);
      std::vector<std::vector<CloudPoint>> sweeps = topic.first_sweeps;
      for (std::vector<CloudPoint>& sweep : sweeps) {
        for (CloudPoint& point : sweep) point.position = table_from_cloud * point.position;
      }
      RecordedLidar lidar = fit_recorded(requested, sweeps, apart_s(topic), stamp, file_, requested.topic);
      lidar.table_from_cloud = table_from_cloud;
      lidar.model.name = name_of_topic(requested.topic);
      log_.lidars.push_back({lidar.model, mount_of(requested.topic, frame, false)});
      std::string text = fmt::format("LiDAR {}: {}, {:.4g} Hz; {}",
                                     lidar.model.name,
                                     requested.topic,
                                     1.0 / lidar.model.sweep_s,
                                     topic.fields->reported());
      for (const std::string& more : lidar.notes) text += "; " + more;
      note(text);
      if (!lidars_.emplace(requested.topic, std::move(lidar)).second)
        refuse_option("--lidar", requested.topic, "each topic once");
    }
    for (const auto& [topic, unused] : scan_.clouds) {
      if (lidars_.count(topic) == 0) note("left out: " + topic + ", no --lidar names it");
    }
  }

  /// For rectified pictures P determines the lens: no distortion.
  void rectify(CameraInfoMessage& info, const std::string& topic) const {
    constexpr std::array<double, 9> kUnturned{1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (info.p[0] != 0.0) info.k = {info.p[0], 0, info.p[2], 0, info.p[5], info.p[6], 0, 0, 1};
    const bool is_distorted = std::any_of(info.d.begin(), info.d.end(), [](double v) { return v != 0.0; });
    double turned = 0.0;
    for (std::size_t i = 0; i < kUnturned.size(); ++i)
      turned = std::max(turned, std::abs(info.r[i] - kUnturned[i]));
    constexpr double kTurned = 1e-6;
    if ((info.p[0] == 0.0 && is_distorted) || (turned > kTurned && info.r != std::array<double, 9>{})) {
      throw_input_error(file_,
                        topic,
                        info.p[0] == 0.0 ? "rectified pictures and no P" : "rectified pictures turned by R",
                        "raw ones: --cameras names them");
    }
    info.d.clear();
    info.distortion_model.clear();
  }

  void choose_cameras() {
    for (const std::string& topic : options_.cameras) {
      if (scan_.pictures.count(topic) == 0) {
        need_sound(topic);
        refuse_option("--cameras", topic, "a topic of pictures: " + names(scan_.pictures));
      }
    }
    for (const auto& [topic, unused] : options_.lenses) {
      if (scan_.pictures.count(topic) == 0)
        refuse_option("--camera", topic, "a topic of pictures: " + names(scan_.pictures));
    }
    std::map<std::string, std::string> taken;  // by the picture that they describe
    for (const auto& [topic, pictures] : scan_.pictures) {
      const auto lens = options_.lenses.find(topic);
      const bool has_lens = lens != options_.lenses.end();
      const bool is_requested =
          has_lens ||
          std::find(options_.cameras.begin(), options_.cameras.end(), topic) != options_.cameras.end();
      if (!options_.cameras.empty() && !is_requested) continue;
      if (!pictures.unreadable.empty()) {
        if (is_requested)
          throw_input_error(file_, topic, pictures.unreadable, "colours: JPEG, PNG, WebP, rgb8 ...");
        note("left out: " + topic + ", " + pictures.unreadable);
        continue;
      }
      const auto info = scan_.infos.find(folder_of(topic) + "/camera_info");
      if (info == scan_.infos.end() && !has_lens) {
        const std::string lacks = "no " + folder_of(topic) + "/camera_info";
        if (is_requested)
          throw_input_error(file_, topic, lacks, "a CameraInfo topic beside it, or --camera TOPIC=FILE");
        note("left out: " + topic + ", " + lacks);
        continue;
      }
      if (!has_lens && scan_.changing.count(info->first) != 0) {
        const std::string found = "a calibration that changes";
        if (is_requested)
          throw_input_error(file_, info->first, found, "one for the whole drive, or --camera TOPIC=FILE");
        note("left out: " + topic + ", " + info->first + " has " + found);
        continue;
      }
      const auto [same, is_first] = taken.emplace(folder_of(topic), topic);
      if (!is_first) {
        if (is_requested)
          refuse_option("--cameras", topic, "one topic of a camera; " + same->second + " is of the same");
        note("left out: " + topic + ", of the same camera as " + same->second);
        continue;
      }
      RecordedCamera recorded;
      Camera camera;
      Pose mount;
      try {
        mount = mount_of(topic, pictures.frame_id, true);
        if (has_lens) {
          camera = lens->second.model;
          camera.name = name_of_topic(topic);
          recorded.readout_s = lens->second.readout_s;
        } else {
          CameraInfoMessage message = info->second;
          if (topic.find("/image_rect", folder_of(topic).size()) != std::string::npos)
            rectify(message, topic);
          camera = camera_of(message, name_of_topic(topic), file_, info->first);
        }
      } catch (const Error& error) {
        if (is_requested) throw;
        note(fmt::format("left out: {}: {}", topic, error.what()));
        continue;
      }
      const auto shutter = options_.shutters.find(topic);
      if (shutter != options_.shutters.end()) {
        camera.shutter = shutter->second.kind;
        recorded.readout_s = shutter->second.readout_s;
      }
      recorded.name = camera.name;
      note(fmt::format("camera {}: {}, {}, {}",
                       camera.name,
                       topic,
                       to_string(camera.lens.kind()),
                       to_string(camera.shutter)));
      log_.cameras.push_back({std::move(camera), mount});
      cameras_.emplace(topic, std::move(recorded));
    }
  }

  void find_path() {
    for (const auto& [topic, unused] : lidars_) add_span(scan_.clouds.at(topic));
    for (const auto& [topic, unused] : cameras_) add_span(scan_.pictures.at(topic));
    log_.start_ns = span_.first;
    log_.name = name_from(options_.recording.stem().string());
    std::vector<StampedPose> path;
    if (!options_.without_poses) path = recorded_path();
    std::vector<TimedPose> poses;
    for (const StampedPose& pose : path)
      poses.push_back({static_cast<double>(pose.stamp_ns - log_.start_ns) * kNanosecond_s, pose.pose});
    if (options_.without_poses) {
      constexpr double kBeyond_s = 1.0;  // so that the last sweep ends within it
      poses = {{-kBeyond_s, {}},
               {static_cast<double>(span_.second - span_.first) * kNanosecond_s + kBeyond_s, {}}};
      note("no poses: a rig at rest");
    } else if (poses.empty()) {
      throw_input_error(
          file_,
          "path of " + options_.rig_frame,
          fmt::format("none; frames: {}; odometry: {}", scan_.transforms.frames(), names(scan_.odometry)),
          "transforms or odometry that move it, --rig-frame, --odometry, or --no-poses");
    }
    level(poses);
    log_.world_from_rig = Trajectory(std::move(poses));
    const auto [first_ns, last_ns] = span_;
    frames_s_ = {static_cast<double>(first_ns) * kNanosecond_s, static_cast<double>(last_ns) * kNanosecond_s};
    span_ = {first_ns + static_cast<std::int64_t>(
                            (log_.world_from_rig.start_s() - Trajectory::kExtrapolation_s) / kNanosecond_s),
             first_ns + static_cast<std::int64_t>(
                            (log_.world_from_rig.end_s() + Trajectory::kExtrapolation_s) / kNanosecond_s)};
  }

  /// Levels the world such that the rig is upright on average: a world with z down, or aligned with an IMU's or
  /// a camera's first pose, is rotated by the smallest angle. A tilt that roads may have is reported, and
  /// removed if the rig has it in the same world direction at all headings.
  void level(std::vector<TimedPose>& poses) {
    constexpr double kSteepest = 20.0 * kDegree;  // steeper than any road
    constexpr double kWorthTelling = 3.0 * kDegree;
    constexpr double kManyWays = 0.9, kOnePlane = 0.25;  // length of the mean heading; of the tilt
    Eigen::Vector3d up = Eigen::Vector3d::Zero(), ahead = Eigen::Vector3d::Zero();
    for (const TimedPose& p : poses) {
      up += p.pose.rotation * Eigen::Vector3d::UnitZ() / static_cast<double>(poses.size());
      ahead += p.pose.rotation * Eigen::Vector3d::UnitX() / static_cast<double>(poses.size());
    }
    const double tilt = std::acos(std::clamp(up.normalized().z(), -1.0, 1.0));
    if (!(tilt > kWorthTelling) || up.norm() < 0.5) return;
    const bool is_plane = ahead.norm() < kManyWays && std::acos(std::min(1.0, up.norm())) < kOnePlane * tilt;
    if (tilt <= kSteepest && !is_plane) {
      note(fmt::format(
          "{} leans by {:.1f} degrees on average: a slope, or the path's frame is not level (--world-frame)",
          options_.rig_frame,
          tilt / kDegree));
      return;
    }
    const Pose turn{turn_between(up, Eigen::Vector3d::UnitZ()), Eigen::Vector3d::Zero()};
    for (TimedPose& p : poses) p.pose = turn * p.pose;
    note(fmt::format("the world frame is rotated by {:.1f} degrees, so that {} is upright and z is up",
                     tilt / kDegree,
                     options_.rig_frame));
  }

  void add_span(const SensorTopic& topic) {
    for (const std::int64_t ns : topic.stamps_ns) {
      span_.first = std::min(span_.first, ns);
      span_.second = std::max(span_.second, ns);
    }
  }

  std::vector<StampedPose> recorded_path() {
    if (options_.odometry.empty() &&
        (scan_.transforms.has(options_.rig_frame) || !options_.world_frame.empty())) {
      std::string world = options_.world_frame;
      std::vector<StampedPose> path = scan_.transforms.path(options_.rig_frame, world);
      if (!path.empty()) {
        note(fmt::format("path: {} in {}, {} poses of transforms", options_.rig_frame, world, path.size()));
        return path;
      }
    }
    std::string topic = options_.odometry;
    if (topic.empty() && scan_.odometry.size() == 1) topic = scan_.odometry.begin()->first;
    if (topic.empty()) return {};
    const auto found = scan_.odometry.find(topic);
    if (found == scan_.odometry.end())
      refuse_option("--odometry", topic, "a topic of Odometry: " + names(scan_.odometry));
    std::string child = frame_name(scan_.odometry_frames.at(topic).child_frame_id);
    if (child.empty()) child = options_.rig_frame;
    const auto child_from_rig =
        child == options_.rig_frame ? Pose{} : scan_.transforms.fixed(child, options_.rig_frame);
    if (!child_from_rig) {
      throw_input_error(file_,
                        topic + ": child_frame_id",
                        child,
                        fmt::format("{}, or a frame that is fixed to it", options_.rig_frame));
    }
    std::vector<StampedPose> path = found->second;
    for (StampedPose& pose : path) pose.pose = pose.pose * *child_from_rig;
    sort_by_stamp(path);
    note(fmt::format("path: {} of {}, {} poses", options_.rig_frame, topic, path.size()));
    return path;
  }

  const Ros2Options& options_;
  Ros2Report& report_;
  std::string file_;
  std::unique_ptr<const Bag> bag_;
  Scan scan_;
  Log log_;
  std::pair<double, double> frames_s_;  // first and last stamp of clouds and pictures
  std::set<std::string> names_;
  std::map<std::string, RecordedLidar> lidars_;    // by topic
  std::map<std::string, RecordedCamera> cameras_;  // by topic
  std::pair<std::int64_t, std::int64_t> span_{std::numeric_limits<std::int64_t>::max(),
                                              std::numeric_limits<std::int64_t>::min()};
};

}  // namespace

Log import_ros2(const Ros2Options& options, const FrameProgress& progress, Ros2Report& report) {
  return Importer(options, report).run(progress);
}

}  // namespace simuli
