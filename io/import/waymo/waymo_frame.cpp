#include "io/import/waymo/waymo_frame.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "host/core/base/error.hpp"
#include "host/core/scene/mounting.hpp"
#include "io/base/gzip.hpp"

namespace simuli::waymo {
namespace {

constexpr std::uint64_t kTop = 1;
constexpr std::array<const char*, 6> kCameraNames{
    "UNKNOWN", "FRONT", "FRONT_LEFT", "FRONT_RIGHT", "SIDE_LEFT", "SIDE_RIGHT"};
constexpr std::array<ShutterKind, 6> kShutters{ShutterKind::kGlobal,
                                               ShutterKind::kTopToBottom,
                                               ShutterKind::kLeftToRight,
                                               ShutterKind::kBottomToTop,
                                               ShutterKind::kRightToLeft,
                                               ShutterKind::kGlobal};

int pixels(std::uint64_t value) { return static_cast<int>(std::min<std::uint64_t>(value, 1U << 20U)); }

}  // namespace

Frame Reader::frame(std::string_view bytes) const {
  Frame f;
  const std::vector<WireField> fields = wire_fields(bytes, file_, "frame");
  // Records of other schemas have these field numbers as well and would be read as frames with arbitrary names.
  if (std::none_of(fields.begin(), fields.end(), [](const auto& field) {
        return field.number == 2 && !field.is_bytes;
      }))
    throw_input_error(
        file_,
        "record",
        "no frame but a Scenario or tf.Example, as of the Motion data set, which has no pictures",
        "frames of the Perception data set");
  for (const WireField& field : fields) {
    if (field.number == 1) context(field.bytes, f);
    if (field.number == 2) f.time_s = static_cast<double>(field.value) * 1e-6;
    if (field.number == 3) f.world_from_vehicle = transform(field.bytes);
    if (field.number == 4) picture(field.bytes, f);
    if (field.number == 5) laser(field.bytes, f);
    if (field.number == 6) f.boxes.push_back(box(field.bytes));
  }
  return f;
}

LogCamera Reader::camera(std::string_view bytes) const {
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

bool Reader::lidar(std::string_view bytes, std::size_t rows, std::size_t columns, LogLidar& out) const {
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
  // Range images begin behind the vehicle, independent of the sensor's mounting.
  const Eigen::Vector3d ahead = out.rig_from_lidar.rotation * Eigen::Vector3d::UnitX();
  model.azimuth_first =
      std::numbers::pi * (1.0 - 1.0 / static_cast<double>(columns)) - std::atan2(ahead.y(), ahead.x());
  validate(model, file_);
  out.model = model;
  return true;
}

Grid Reader::grid(std::string_view compressed) const {
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
  const bool good = dims.size() == 3 && dims[0] >= 1 && dims[0] <= 4096 && dims[1] >= 1 && dims[1] <= 65536 &&
                    dims[2] >= 2 && dims[2] <= 16 && dims[0] * dims[1] * dims[2] == out.values.size();
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

std::string Reader::camera_name(std::uint64_t name) const {
  if (name < kCameraNames.size()) return kCameraNames[name];
  throw_input_error(file_, "camera name", fmt::format("{}", name), "1 to 5");
}

Pose Reader::transform(std::string_view bytes) const {
  std::vector<double> v;
  for (const WireField& field : wire_fields(bytes, file_, "transform")) {
    if (field.number == 1) append_doubles(field, v);
  }
  if (v.size() != 16) throw_input_error(file_, "transform", fmt::format("{} numbers", v.size()), "16");
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> m(v.data());
  constexpr double kSlack = 1e-5;  // for single precision
  if (!m.row(3).isApprox(Eigen::RowVector4d::UnitW(), kSlack)) {
    throw_input_error(file_, "transform", "another last row (is it transposed?)", "0 0 0 1");
  }
  return with_context("reading " + file_, [&] { return Pose::from_matrix(m.topRows<3>()); });
}

void Reader::context(std::string_view bytes, Frame& f) const {
  for (const WireField& field : wire_fields(bytes, file_, "context")) {
    if (field.number == 1) f.name = std::string(field.bytes);
    if (field.number == 2) f.cameras.push_back(field.bytes);
    if (field.number == 3) f.lidars.push_back(field.bytes);
  }
}

void Reader::picture(std::string_view bytes, Frame& f) const {
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

void Reader::laser(std::string_view bytes, Frame& f) const {
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

Box Reader::box(std::string_view bytes) const {
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

Sweep sweep_of(const Grid& grid, const Lidar& lidar) {
  Sweep sweep;
  sweep.rays = nominal_rays(lidar);
  for (std::size_t i = 0; i < grid.rows * grid.columns; ++i) {
    const float range = grid.values[i * grid.channels];
    const bool returned = range > 0.0F && range < 1e4F;
    const float intensity = std::tanh(std::max(0.0F, grid.values[i * grid.channels + 1]));
    sweep.range.push_back(returned ? range : 0.0F);
    sweep.intensity.push_back(returned && std::isfinite(intensity) ? intensity : 0.0F);
  }
  return sweep;
}

}  // namespace simuli::waymo
