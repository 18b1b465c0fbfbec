#include "io/import/pandaset/pandaset.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <complex>
#include <fmt/format.h>
#include <optional>
#include <set>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/pandaset/pandaset_parts.hpp"
#include "io/log/new_log.hpp"
#include "io/picture/image.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace pandaset;

constexpr const char* kFront = "front_camera";
constexpr const char* kPandar64 = "pandar64";
constexpr const char* kPandarGt = "pandargt";

// Pictures are read out from top to bottom in 30 ms; their stamp is 10 ms after the middle row (neurad-studio,
// pandaset_dataparser.py: rolling_shutter_time, time_to_center_pixel).
constexpr double kReadFrom_s = -0.025, kReadTo_s = 0.005;

// The lowest rows of the back camera show the ego vehicle; evaluations leave them out as well.
constexpr const char* kSeesVehicle = "back_camera";
constexpr double kVehicle = 260.0 / 1080.0;

// The Pandar64's mounting is estimated from about 5000 points of all sweeps.
constexpr std::size_t kEvery = 20;

/// Returns the pose with the least squared distances from all poses: the mean of their positions, and the
/// principal axis of their quaternions, independent of signs.
Pose mean_of(const std::vector<Pose>& poses) {
  Eigen::Matrix4d agreement = Eigen::Matrix4d::Zero();
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (const Pose& pose : poses) {
    agreement += pose.rotation.coeffs() * pose.rotation.coeffs().transpose();
    place += pose.translation / static_cast<double>(poses.size());
  }
  // Compiles faster than an eigensolver of this size.
  const Eigen::JacobiSVD<Eigen::Matrix4d, Eigen::NoQRPreconditioner> svd(agreement, Eigen::ComputeFullV);
  Eigen::Quaterniond rotation(Eigen::Vector4d(svd.matrixV().col(0)));
  if (rotation.w() < 0.0) rotation.coeffs() = -rotation.coeffs();
  return {rotation.normalized(), place};
}

/// Sum of exp(i (azimuth less that of a uniform rotation)) in both directions.
struct Spin {
  std::complex<double> counter_clockwise, clockwise;
  double points = 0.0;

  void add(double azimuth, double share) {
    counter_clockwise += std::polar(1.0, azimuth - kTurn * share);
    clockwise += std::polar(1.0, azimuth + kTurn * share);
    points += 1.0;
  }
};

class Importer {
 public:
  Importer(const PandasetOptions& options, PandasetReport& report)
      : options_(options),
        report_(report),
        folder_((fs::current_path() / options.sequence).lexically_normal()) {
    if (!folder_.has_filename()) folder_ = folder_.parent_path();
    find_sensors();
    const Posed front = read_posed(folder_ / "camera" / kFront);
    count_ = front.poses.size();
    last_ = std::min(options.last, count_ - 1);
    if (options.first > last_ || (options.last != PandasetOptions{}.last && options.last >= count_)) {
      throw_input_error(folder_.string(),
                        "frames",
                        fmt::format("{} to {}", options.first, options.last),
                        fmt::format("first to last from 0 to {}, which the sequence has", count_ - 1));
    }
    log_.name = name_from(folder_.filename().string());
    set_path(front);
    for (const std::string& name : cameras_) set_mount(name);
    find_files();
  }

  Log write(const FrameProgress& progress) {
    return make_import(options_.output, log_, [&] {
      LogMaker maker(log_, progress, 2 * clouds_.size() + pictures_.size());
      survey_clouds(maker);
      for (const auto& [number, file] : clouds_) {
        add_cloud(number, file, maker);
        maker.step();
      }
      need_placed(report_.points, (folder_ / "lidar").string());
      for (const Picture& picture : pictures_) {
        add_picture(picture, maker);
        maker.step();
      }
      hide_vehicle();
      log_.actors = boxes_.take((folder_ / "annotations" / "cuboids").string(), report_);
    });
  }

 private:
  struct Picture {
    std::string camera;
    std::size_t number = 0;
    fs::path file;
  };

  void find_sensors() {
    std::error_code failed;
    std::vector<std::string> known;
    for (const auto& entry : fs::directory_iterator(folder_ / "camera", failed)) {
      if (entry.is_directory()) known.push_back(entry.path().filename().string());
    }
    std::sort(known.begin(), known.end());
    if (known.empty())
      throw_input_error((folder_ / "camera").string(), "folders", "none", "front_camera and others");
    cameras_ = requested_sensors(options_.cameras, known, "camera");
    lidars_ = requested_sensors(options_.lidars, {kPandar64, kPandarGt}, "LiDAR");
    for (const std::string& name : cameras_) need_name(name, folder_.string(), "camera");
  }

  [[nodiscard]] bool has_lidar(const std::string& name) const {
    return std::find(lidars_.begin(), lidars_.end(), name) != lidars_.end();
  }

  void set_path(const Posed& front) {
    const Pose rig_from_theirs = rig_from_pandar64();
    const Pose camera_from_rig = camera_from_pandar64() * rig_from_theirs.inverse();
    frame_.world_from_theirs = (front.poses.front() * camera_from_rig).inverse();
    frame_.start_ns = front.times_ns.front();
    log_.start_ns = frame_.start_ns;
    std::vector<TimedPose> all;
    for (std::size_t i = 0; i < count_; ++i) {
      all.push_back(
          {frame_.seconds(front.times_ns[i]), frame_.world_from_theirs * front.poses[i] * camera_from_rig});
    }
    whole_path_ = Trajectory(all);
    // One more pose at each end, because sensors record before and after the front camera.
    const std::size_t from = options_.first == 0 ? 0 : options_.first - 1, to = std::min(last_ + 2, count_);
    log_.world_from_rig = Trajectory(
        {all.begin() + static_cast<std::ptrdiff_t>(from), all.begin() + static_cast<std::ptrdiff_t>(to)});
  }

  /// Sets a camera's mounting from the poses of all its pictures.
  void set_mount(const std::string& name) {
    const fs::path folder = folder_ / "camera" / name;
    const Posed posed = read_posed(folder);
    std::vector<Pose> mounts;
    for (std::size_t i = 0; i < posed.poses.size(); ++i) {
      const double time_s = frame_.seconds(posed.times_ns[i]);
      if (time_s < whole_path_.start_s() || time_s > whole_path_.end_s()) continue;
      mounts.push_back(whole_path_.at(time_s).inverse() * frame_.world_from_theirs * posed.poses[i]);
    }
    if (mounts.empty())
      throw_input_error((folder / "timestamps.json").string(), "times", "none during the path", "some");
    LogCamera camera{{}, mean_of(mounts)};
    PandasetMount mount{name, mounts.size(), 0.0, 0.0};
    for (const Pose& own : mounts) {
      mount.off_m += (own.translation - camera.rig_from_camera.translation).squaredNorm();
      mount.off_rad += std::pow(own.rotation.angularDistance(camera.rig_from_camera.rotation), 2);
    }
    mount.off_m = std::sqrt(mount.off_m / static_cast<double>(mounts.size()));
    mount.off_rad = std::sqrt(mount.off_rad / static_cast<double>(mounts.size()));
    report_.mounts.push_back(mount);
    camera.model.name = name;
    camera.model.shutter = ShutterKind::kTopToBottom;
    const fs::path file = folder / "intrinsics.json";
    read_json_text(read_file(file), file.string(), [&](JsonObject& k) {
      k.ignore_other_keys();
      camera.model.fx = k.number("fx");
      camera.model.fy = k.number("fy");
      camera.model.cx =
          k.number("cx") + 0.5;  // principal points are relative to the centre of the first pixel
      camera.model.cy = k.number("cy") + 0.5;
    });
    log_.cameras.push_back(std::move(camera));
    stamps_[name] = posed.times_ns;
  }

  [[nodiscard]] static std::optional<fs::path> there(const fs::path& folder,
                                                     std::size_t number,
                                                     std::initializer_list<const char*> endings) {
    for (const char* const ending : endings) {
      const fs::path file = folder / fmt::format("{:02}{}", number, ending);
      if (!is_there(file)) continue;
      need_regular_file(file);
      return file;
    }
    return {};
  }

  /// Finds the existing files and reports missing ones.
  void find_files() {
    std::map<std::string, std::vector<std::size_t>> absent;
    PandasetGap nothing{"all sensors", {}};
    for (std::size_t i = options_.first; i <= last_; ++i) {
      std::vector<std::string> lacking;
      for (const std::string& name : cameras_) {
        const auto picture = there(folder_ / "camera" / name, i, {".jpg"});
        if (picture && i >= stamps_.at(name).size())
          throw_input_error(picture->string(), "pose", "none in poses.json", "one for each picture");
        if (picture) pictures_.push_back({name, i, *picture});
        if (!picture) lacking.push_back(name);
      }
      const auto cloud = there(folder_ / "lidar", i, {".pkl.gz", ".pkl"});
      if (cloud) clouds_.emplace(i, *cloud);
      if (!cloud) lacking.emplace_back("lidar");
      const auto labels = there(folder_ / "annotations" / "cuboids", i, {".pkl.gz", ".pkl"});
      if (labels) labels_.emplace(i, *labels);
      if (lacking.size() == cameras_.size() + 1) {
        nothing.frames.push_back(i);
        continue;
      }
      if (!labels) lacking.emplace_back("cuboids");
      for (const std::string& sensor : lacking) absent[sensor].push_back(i);
    }
    if (pictures_.empty() && clouds_.empty()) {
      throw_nothing_left(folder_.string(),
                         "frames",
                         fmt::format("no picture and no sweep of {} to {}", options_.first, last_),
                         "at least one");
    }
    if (!nothing.frames.empty()) report_.gaps.push_back(nothing);
    for (auto& [sensor, frames] : absent) report_.gaps.push_back({sensor, std::move(frames)});
  }

  /// Determines properties of all sweeps before the first is written: the Pandar64's rotation, and the number
  /// of points of the PandarGT's largest sweep.
  void survey_clouds(LogMaker& maker) {
    Spin spin;
    std::vector<Eigen::Vector3d> some;
    const std::size_t every = std::max<std::size_t>(1, kEvery * clouds_.size());
    std::vector<MeasuredPoint> fullest;
    double farthest_m = 1.0, before_s = -kLongestSweep_s;
    for (const auto& [number, file] : clouds_) {
      const auto points = read_points(file, frame_);
      if (const auto own = points.find(PointSource::kPandar64); own != points.end() && has_lidar(kPandar64)) {
        const auto seen = measured(own->second, rig_from_pandar64(), usual_span(own->second));
        for (std::size_t i = 0; i < seen.size(); ++i) {
          spin.add(std::atan2(seen[i].position.y(), seen[i].position.x()), seen[i].time_fraction);
          if (i % every == 0) some.push_back(seen[i].position);
        }
      }
      if (const auto own = points.find(PointSource::kPandarGt); own != points.end() && has_lidar(kPandarGt)) {
        if (own->second.first_s() <= before_s) {
          ++report_.list_again;
          repeated_.insert(number);
        } else {
          const auto seen = measured(own->second, mount_of_list(), whole_span(own->second));
          for (const MeasuredPoint& p : seen) farthest_m = std::max(farthest_m, p.position.norm());
          if (seen.size() > fullest.size()) fullest = seen;
        }
        before_s = own->second.first_s();
      }
      maker.step();
    }
    if (spin.points > 0.0) add_pandar64(spin, some);
    if (!fullest.empty()) add_list(fullest, farthest_m);
  }

  void add_pandar64(const Spin& spin, const std::vector<Eigen::Vector3d>& points) {
    const std::complex<double> sum =
        std::abs(spin.clockwise) > std::abs(spin.counter_clockwise) ? spin.clockwise : spin.counter_clockwise;
    report_.spin_agreement = std::abs(sum) / spin.points;
    report_.is_clockwise = sum == spin.clockwise;
    constexpr double kLeastAgreement = 0.9;
    if (report_.spin_agreement < kLeastAgreement) {
      throw_input_error((folder_ / "lidar").string(),
                        "times of the Pandar64's points",
                        fmt::format("agreement {:.3f} with an even turn", report_.spin_agreement),
                        fmt::format("at least {}", kLeastAgreement));
    }
    Lidar model = builtin_lidar("ncore_pandaset_pandar64");
    model.name = kPandar64;
    model.spin = report_.is_clockwise ? SpinDirection::kClockwise : SpinDirection::kCounterClockwise;
    const double half_column = 0.5 * model.azimuth_span / model.columns;
    model.azimuth_first = std::remainder(std::arg(sum) + model.spin_sign() * half_column, kTurn);
    report_.mounting = unit_mounting(model, points);
    const Pose rig_from_table = rig_from_pandar64() * report_.mounting.table_from_sensor.inverse();
    log_.lidars.push_back({std::move(model), rig_from_table});
  }

  void add_list(const std::vector<MeasuredPoint>& fullest, double farthest_m) {
    RayList list;
    list.name = kPandarGt;
    list.range_max = std::ceil(farthest_m);
    for (const MeasuredPoint& p : fullest) {
      list.azimuth.push_back(std::atan2(p.position.y(), p.position.x()));
      list.elevation.push_back(std::atan2(p.position.z(), p.position.head<2>().norm()));
      list.time_fraction.push_back(p.time_fraction);
    }
    validate(list, (folder_ / "lidar").string());
    report_.list_rays = list.ray_count();
    log_.lidars.push_back({std::move(list), mount_of_list()});
  }

  /// Channels have different azimuth offsets and files are cut by azimuth: the last points belong to the next
  /// revolution.
  [[nodiscard]] static FrameSpan usual_span(const PointFrame& points) {
    return {points.first_s(), points.first_s() + kUsualSweep_s};
  }
  [[nodiscard]] static FrameSpan whole_span(const PointFrame& points) {
    return {points.first_s(), std::max(points.last_s(), points.first_s() + 1e-6)};
  }
  [[nodiscard]] static Pose mount_of_list() { return rig_from_pandar64() * pandar64_from_pandargt(); }

  /// Returns the points in the sensor's frame, each at its own time.
  [[nodiscard]] std::vector<MeasuredPoint> measured(const PointFrame& points,
                                                    const Pose& rig_from_sensor,
                                                    const FrameSpan& span) const {
    std::vector<MeasuredPoint> out(points.position.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Pose world_from_sensor = whole_path_.at(points.time_s[i]) * rig_from_sensor;
      out[i].position = world_from_sensor.inverse() * points.position[i];
      out[i].intensity = points.intensity[i];
      out[i].time_fraction = (points.time_s[i] - span.time_start_s) / (span.time_end_s - span.time_start_s);
    }
    return out;
  }

  void add_cloud(std::size_t number, const fs::path& file, LogMaker& maker) {
    const auto points = read_points(file, frame_);
    for (const LogLidar& lidar : log_.lidars) {
      const bool is_list = std::holds_alternative<RayList>(lidar.model);
      const auto own = points.find(is_list ? PointSource::kPandarGt : PointSource::kPandar64);
      if (own == points.end() || (is_list && repeated_.contains(number))) continue;
      const FrameSpan span = is_list ? whole_span(own->second) : usual_span(own->second);
      const std::vector<MeasuredPoint> seen = measured(own->second, lidar.rig_from_lidar, span);
      const std::string name = name_of(lidar.model), stem = fmt::format("{}_{:06}", name, number);
      if (is_list) {
        maker.add_sweep(name, stem, listed(seen), span);
      } else {
        Lidar model = lidar.with_rows();
        model.sweep_s = kUsualSweep_s;
        maker.add_sweep(name, stem, grid_points(seen, model, report_.points), span);
      }
    }
    const auto labels = labels_.find(number);
    if (labels == labels_.end()) return;
    boxes_.add(DataFrame(labels->second), labels->second.string(), points, frame_, front_s(number));
  }

  [[nodiscard]] double front_s(std::size_t number) const { return whole_path_.poses()[number].time_s; }

  /// Returns the points as rays; repeats some of them up to the size of the list.
  Sweep listed(const std::vector<MeasuredPoint>& points) {
    Sweep sweep;
    sweep.rays.rows = 1;
    sweep.rays.columns = static_cast<int>(report_.list_rays);
    const std::size_t more = report_.list_rays - points.size();
    for (std::size_t i = 0; i < report_.list_rays; ++i) {
      const MeasuredPoint& p = points[i < points.size() ? i : (i - points.size()) * points.size() / more];
      sweep.rays.azimuth.push_back(static_cast<float>(std::atan2(p.position.y(), p.position.x())));
      sweep.rays.elevation.push_back(
          static_cast<float>(std::atan2(p.position.z(), p.position.head<2>().norm())));
      sweep.rays.time_fraction.push_back(static_cast<float>(p.time_fraction));
      sweep.range.push_back(static_cast<float>(p.position.norm()));
      sweep.intensity.push_back(p.intensity);
    }
    report_.list_points += points.size();
    report_.list_repeated += more;
    return sweep;
  }

  void add_picture(const Picture& picture, LogMaker& maker) {
    Camera& camera = std::find_if(log_.cameras.begin(), log_.cameras.end(), [&](const LogCamera& c) {
                       return c.model.name == picture.camera;
                     })->model;
    if (camera.width == 0) {
      const Image first = read_image(picture.file);
      camera.width = first.width;
      camera.height = first.height;
      validate(camera, (picture.file.parent_path() / "intrinsics.json").string());
    }
    const double stamp_s = frame_.seconds(stamps_.at(picture.camera)[picture.number]);
    maker.add_picture(camera,
                      fmt::format("{}_{:06}", picture.camera, picture.number),
                      picture.file,
                      picture.camera + "'s first picture",
                      {stamp_s + kReadFrom_s, stamp_s + kReadTo_s});
  }

  void hide_vehicle() {
    // The size of a camera without pictures is unknown; it is left out.
    std::erase_if(log_.cameras, [](const LogCamera& c) { return c.model.width == 0; });
    report_.hidden = hide_lowest(log_, kSeesVehicle, kVehicle);
  }

  const PandasetOptions& options_;
  PandasetReport& report_;
  fs::path folder_;
  std::size_t count_ = 0, last_ = 0;
  std::vector<std::string> cameras_, lidars_;
  Frame frame_;
  Trajectory whole_path_;
  std::map<std::string, std::vector<std::int64_t>> stamps_;  // by camera
  std::vector<Picture> pictures_;
  std::map<std::size_t, fs::path> clouds_, labels_;  // by frame
  std::set<std::size_t> repeated_;  // frames that repeat another frame's sweep of the PandarGT
  Boxes boxes_;
  Log log_;
};

}  // namespace

Log import_pandaset(const PandasetOptions& options, const FrameProgress& progress, PandasetReport& report) {
  return Importer(options, report).write(progress);
}

}  // namespace simuli
