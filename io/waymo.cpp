#include "io/waymo.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "io/file.hpp"
#include "io/gzip.hpp"
#include "io/tfrecord.hpp"
#include "io/wire.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

// Numbers of fields and values after the data set's published schema (dataset.proto, label.proto).
constexpr std::uint64_t kTop = 1;
constexpr std::array<const char*, 6> kCameraNames{
    "UNKNOWN", "FRONT", "FRONT_LEFT", "FRONT_RIGHT", "SIDE_LEFT", "SIDE_RIGHT"};
constexpr std::array<const char*, 5> kLabelKinds{"unknown", "vehicle", "pedestrian", "sign", "cyclist"};
constexpr std::array<ShutterKind, 6> kShutters{ShutterKind::kGlobal,
                                               ShutterKind::kTopToBottom,
                                               ShutterKind::kLeftToRight,
                                               ShutterKind::kBottomToTop,
                                               ShutterKind::kRightToLeft,
                                               ShutterKind::kGlobal};
/// Their cameras look along x, y left, z up.
const Eigen::Quaterniond kForwardFromCamera(0.5, -0.5, 0.5, -0.5);

/// What a frame has of a sensor: in seconds since 1970, which a double holds to a quarter of a microsecond.
struct Picture {
  std::uint64_t name = 0;
  std::string_view bytes;
  double start_s = 0.0, end_s = 0.0;
};
struct Box {
  std::string id;
  std::uint64_t type = 0;
  std::array<double, 8> values{};  // by field: center 1 to 3, width, length, height, heading
};
struct Frame {
  std::string name;
  std::vector<std::string_view> cameras, lidars;  // calibrations
  double time_s = 0.0;
  Pose world_from_vehicle;
  std::vector<Picture> pictures;
  std::vector<std::pair<double, Pose>> poses;  // of the pictures
  std::string_view top;                        // range image, compressed
  std::vector<Box> boxes;
};

/// One segment being read. `file_` is for messages.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  [[nodiscard]] Frame frame(std::string_view bytes) const {
    Frame f;
    for (const WireField& field : wire_fields(bytes, file_, "frame")) {
      if (field.number == 1) context(field.bytes, f);
      if (field.number == 2) f.time_s = static_cast<double>(field.value) * 1e-6;
      if (field.number == 3) f.world_from_vehicle = transform(field.bytes);
      if (field.number == 4) picture(field.bytes, f);
      if (field.number == 5) laser(field.bytes, f);
      if (field.number == 6) f.boxes.push_back(box(field.bytes));
    }
    return f;
  }

  [[nodiscard]] LogCamera camera(std::string_view bytes) const {
    LogCamera out;
    std::vector<double> k;
    std::uint64_t name = 0;
    for (const WireField& field : wire_fields(bytes, file_, "camera calibration")) {
      if (field.number == 1) name = field.value;
      if (field.number == 2) append_doubles(field, k);
      if (field.number == 3) out.rig_from_camera = transform(field.bytes);
      if (field.number == 4) out.model.width = pixels(field.value);
      if (field.number == 5) out.model.height = pixels(field.value);
      if (field.number == 6) out.model.shutter = kShutters.at(std::min<std::uint64_t>(field.value, 5));
    }
    if (k.size() < 9) {
      throw_input_error(file_, "camera intrinsic", fmt::format("{} numbers", k.size()), "9");
    }
    Camera& c = out.model;
    c.name = camera_name(name);
    c.fx = k[0];
    c.fy = k[1];
    c.cx = k[2] + 0.5;
    c.cy = k[3] + 0.5;
    std::vector<double> lens(lens_parameter_names(LensKind::kOpencvPinhole).size(), 0.0);
    std::copy(k.begin() + 4, k.begin() + 9, lens.begin());
    lens.back() = std::numbers::pi;
    c.lens = Lens(LensKind::kOpencvPinhole, lens, file_);
    out.rig_from_camera = out.rig_from_camera * Pose{kForwardFromCamera, {0, 0, 0}};
    validate(c, file_);
    return out;
  }

  /// TOP, for a range image of that size; false for another LiDAR.
  [[nodiscard]] bool lidar(std::string_view bytes,
                           std::size_t rows,
                           std::size_t columns,
                           LogLidar& out) const {
    std::vector<double> inclinations;
    double lowest = 0.0, highest = 0.0;
    std::uint64_t name = 0;
    for (const WireField& field : wire_fields(bytes, file_, "laser calibration")) {
      if (field.number == 1) name = field.value;
      if (field.number == 2) append_doubles(field, inclinations);
      if (field.number == 3) lowest = wire_double(field);
      if (field.number == 4) highest = wire_double(field);
      if (field.number == 5) out.rig_from_lidar = transform(field.bytes);
    }
    if (name != kTop) return false;
    for (std::size_t i = 0; inclinations.size() < rows && i < rows; ++i) {
      const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(rows);
      inclinations.push_back(lowest + share * (highest - lowest));
    }
    if (inclinations.size() != rows) {
      throw_input_error(
          file_, "beam inclinations", fmt::format("{}", inclinations.size()), fmt::format("{}", rows));
    }
    Lidar model = builtin_lidar("ncore_waymo_top");  // for its divergence and ranges
    model.name = "TOP";
    model.rows.assign(rows, {});
    for (std::size_t r = 0; r < rows; ++r) model.rows[r].elevation = inclinations[rows - 1 - r];
    model.columns = static_cast<int>(columns);
    model.spin = SpinDirection::kClockwise;
    model.azimuth_span = 2.0 * std::numbers::pi;
    // Range images begin behind the vehicle, however the sensor is turned on it.
    const Eigen::Vector3d ahead = out.rig_from_lidar.rotation * Eigen::Vector3d::UnitX();
    model.azimuth_first =
        std::numbers::pi * (1.0 - 1.0 / static_cast<double>(columns)) - std::atan2(ahead.y(), ahead.x());
    validate(model, file_);
    out.model = model;
    return true;
  }

  /// The range image: [rows][columns][channels], of which the first two are range and intensity.
  struct Grid {
    std::size_t rows = 0, columns = 0, channels = 0;
    std::vector<float> values;
  };
  [[nodiscard]] Grid grid(std::string_view compressed) const {
    constexpr std::size_t kMost = std::size_t{256} << 20U;
    const std::string bytes = gunzip(std::string(compressed), file_, kMost);
    Grid out;
    std::vector<std::size_t> dims;
    for (const WireField& field : wire_fields(bytes, file_, "range image")) {
      if (field.number == 1) out.values = wire_floats(field.bytes);
      if (field.number != 2) continue;
      for (const WireField& dim : wire_fields(field.bytes, file_, "range image's shape")) {
        dims.push_back(static_cast<std::size_t>(dim.value));
      }
    }
    const bool good = dims.size() == 3 && dims[0] >= 1 && dims[0] <= 4096 && dims[1] >= 1 &&
                      dims[1] <= 65536 && dims[2] >= 2 && dims[2] <= 16 &&
                      dims[0] * dims[1] * dims[2] == out.values.size();
    if (!good) {
      throw_input_error(file_,
                        "range image",
                        fmt::format("{} dimensions and {} values", dims.size(), out.values.size()),
                        "rows, columns and channels that belong together");
    }
    out.rows = dims[0];
    out.columns = dims[1];
    out.channels = dims[2];
    return out;
  }

  [[nodiscard]] std::string camera_name(std::uint64_t name) const {
    if (name < kCameraNames.size()) return kCameraNames[name];
    throw_input_error(file_, "camera name", fmt::format("{}", name), "1 to 5");
  }

 private:
  static int pixels(std::uint64_t value) {
    return static_cast<int>(std::min<std::uint64_t>(value, 1U << 20U));
  }

  [[nodiscard]] Pose transform(std::string_view bytes) const {
    std::vector<double> v;
    for (const WireField& field : wire_fields(bytes, file_, "transform")) {
      if (field.number == 1) append_doubles(field, v);
    }
    if (v.size() != 16) throw_input_error(file_, "transform", fmt::format("{} numbers", v.size()), "16");
    return with_context(file_, [&] {
      return Pose::from_matrix(
          Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(v.data()).topRows<3>());
    });
  }

  void context(std::string_view bytes, Frame& f) const {
    for (const WireField& field : wire_fields(bytes, file_, "context")) {
      if (field.number == 1) f.name = std::string(field.bytes);
      if (field.number == 2) f.cameras.push_back(field.bytes);
      if (field.number == 3) f.lidars.push_back(field.bytes);
    }
  }

  void picture(std::string_view bytes, Frame& f) const {
    Picture p;
    Pose pose;
    double pose_s = 0.0, shutter_s = 0.0, trigger_s = 0.0, done_s = 0.0;
    for (const WireField& field : wire_fields(bytes, file_, "image")) {
      if (field.number == 1) p.name = field.value;
      if (field.number == 2) p.bytes = field.bytes;
      if (field.number == 3) pose = transform(field.bytes);
      if (field.number == 5) pose_s = wire_double(field);
      if (field.number == 6) shutter_s = wire_double(field);
      if (field.number == 7) trigger_s = wire_double(field);
      if (field.number == 8) done_s = wire_double(field);
    }
    p.start_s = trigger_s + 0.5 * shutter_s;
    p.end_s = std::max(p.start_s, done_s - 0.5 * shutter_s);
    if (p.bytes.empty() || !(trigger_s > 0.0)) {
      throw_input_error(file_, "image", "no picture or no time", "both");
    }
    f.pictures.push_back(p);
    f.poses.emplace_back(pose_s, pose);
  }

  void laser(std::string_view bytes, Frame& f) const {
    std::uint64_t name = 0;
    std::string_view image;
    for (const WireField& field : wire_fields(bytes, file_, "laser")) {
      if (field.number == 1) name = field.value;
      if (field.number != 2) continue;
      for (const WireField& part : wire_fields(field.bytes, file_, "laser return")) {
        if (part.number == 2) image = part.bytes;
      }
    }
    if (name == kTop) f.top = image;
  }

  [[nodiscard]] Box box(std::string_view bytes) const {
    Box out;
    for (const WireField& field : wire_fields(bytes, file_, "label")) {
      if (field.number == 3) out.type = field.value;
      if (field.number == 4) out.id = std::string(field.bytes);
      if (field.number != 1) continue;
      for (const WireField& part : wire_fields(field.bytes, file_, "box")) {
        if (part.number < out.values.size()) out.values[part.number] = wire_double(part);
      }
    }
    return out;
  }

  std::string file_;
};

Sweep sweep_of(const Reader::Grid& grid, const Lidar& lidar) {
  Sweep sweep;
  sweep.rays = nominal_rays(lidar, 0.0);
  for (std::size_t i = 0; i < grid.rows * grid.columns; ++i) {
    const float range = grid.values[i * grid.channels];
    const bool returned = range > 0.0F && range < 1e4F;
    const float intensity = std::tanh(std::max(0.0F, grid.values[i * grid.channels + 1]));
    sweep.range.push_back(returned ? range : 0.0F);
    sweep.intensity.push_back(returned && std::isfinite(intensity) ? intensity : 0.0F);
  }
  return sweep;
}

/// Boxes of all frames, one actor per id.
class Boxes {
 public:
  void add(const Frame& frame, double time_s) {
    for (const Box& b : frame.boxes) {
      const std::string kind = kLabelKinds.at(std::min<std::uint64_t>(b.type, 4));
      const auto [entry, is_new] = index_.emplace(b.id, actors_.size());
      if (is_new) {
        actors_.push_back(
            {fmt::format("{}_{}", kind, actors_.size()), kind, {b.values[5], b.values[4], b.values[6]}, {}});
      }
      const Pose vehicle_from_box{
          Eigen::Quaterniond(Eigen::AngleAxisd(b.values[7], Eigen::Vector3d::UnitZ())),
          {b.values[1], b.values[2], b.values[3]}};
      actors_[entry->second].track.push_back({time_s, frame.world_from_vehicle * vehicle_from_box});
    }
  }
  [[nodiscard]] std::vector<Actor> take(const std::string& file) {
    for (const Actor& actor : actors_) validate(actor, file);
    return std::move(actors_);
  }

 private:
  std::vector<Actor> actors_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace

Log import_waymo(const WaymoOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress,
                 WaymoReport& report) {
  const std::string file = options.segment.string();
  const Reader reader(file);
  TfRecords records(options.segment);
  Log log, written;
  std::map<std::int64_t, Pose> path;
  std::vector<double> starts_s;  // of the frames, since 1970
  Boxes boxes;
  write_folder_atomically(options.output, [&](const fs::path& folder) {
    log.folder = folder;
    fs::create_directory(folder / "images");
    fs::create_directory(folder / "sweeps");
    std::string record;
    while (records.next(record)) {
      const Frame frame = reader.frame(record);
      if (starts_s.empty()) {
        log.name = frame.name;
        log.start_ns = static_cast<std::int64_t>(std::llround(frame.time_s * 1e6)) * 1000;
        for (const std::string_view calibration : frame.cameras)
          log.cameras.push_back(reader.camera(calibration));
      }
      const double origin_s = static_cast<double>(log.start_ns) * 1e-9;
      const auto place = [&](double time_s, const Pose& pose) {
        path[std::llround((time_s - origin_s) * 1e9)] = pose;
      };
      for (const auto& [time_s, pose] : frame.poses) place(time_s, pose);
      if (frame.poses.empty()) place(frame.time_s, frame.world_from_vehicle);
      for (const Picture& p : frame.pictures) {
        const std::string name = reader.camera_name(p.name);
        const std::string image = fmt::format("images/{}_{:06}.jpg", name, starts_s.size());
        write_file_atomically(folder / image, std::string(p.bytes));
        const bool global = log.camera(name).model.shutter == ShutterKind::kGlobal;
        const double middle_s = 0.5 * (p.start_s + p.end_s);
        log.images.push_back({name,
                              image,
                              (global ? middle_s : p.start_s) - origin_s,
                              (global ? middle_s : p.end_s) - origin_s});
      }
      if (!frame.top.empty()) {
        const Reader::Grid grid = reader.grid(frame.top);
        for (const std::string_view calibration : frame.lidars) {
          LogLidar lidar;
          if (log.lidars.empty() && reader.lidar(calibration, grid.rows, grid.columns, lidar))
            log.lidars = {lidar};
        }
        if (log.lidars.empty()) throw_input_error(file, "laser calibrations", "none of TOP", "one");
        const Lidar& model = log.lidars[0].with_rows();
        if (grid.rows != model.rows.size() || grid.columns != static_cast<std::size_t>(model.columns)) {
          throw_input_error(file, "range image", "another size than the first", "one size");
        }
        const Sweep sweep = sweep_of(grid, model);
        const std::string name = fmt::format("sweeps/{:06}.exr", starts_s.size());
        write_sweep(folder / name, sweep);
        report.rays += sweep.range.size();
        report.returned += static_cast<std::size_t>(
            std::count_if(sweep.range.begin(), sweep.range.end(), [](float r) { return r > 0.0F; }));
        log.sweeps.push_back({model.name, name, frame.time_s - origin_s, 0.0});
      }
      boxes.add(frame, frame.time_s - origin_s);
      starts_s.push_back(frame.time_s);
      if (progress)
        progress(static_cast<std::size_t>(records.at()), static_cast<std::size_t>(records.size()));
    }
    report.frames = starts_s.size();
    constexpr double kTurn_s = 0.1;
    for (std::size_t i = 0; i < log.sweeps.size(); ++i) {
      const bool follows = i + 1 < log.sweeps.size() &&
                           log.sweeps[i + 1].time_start_s - log.sweeps[i].time_start_s < 1.5 * kTurn_s;
      log.sweeps[i].time_end_s =
          follows ? log.sweeps[i + 1].time_start_s : log.sweeps[i].time_start_s + kTurn_s;
    }
    std::stable_sort(log.images.begin(), log.images.end(), [](const ImageFrame& a, const ImageFrame& b) {
      return a.time_start_s < b.time_start_s;
    });
    log.actors = boxes.take(file);
    std::vector<TimedPose> poses;
    for (const auto& [ns, pose] : path) poses.push_back({static_cast<double>(ns) * 1e-9, pose});
    log.world_from_rig = Trajectory(std::move(poses));
    write_log(log);
    written = read_log(folder);  // what was written is what the next command will read
  });
  written.folder = options.output;
  return written;
}

}  // namespace simuli
