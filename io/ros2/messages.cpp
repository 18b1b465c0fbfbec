#include "io/ros2/messages.hpp"

#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace simuli::ros2 {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

void put(CdrWriter& out, const Header& header) {
  // Rounded down, because nanoseconds count up from the second.
  std::int64_t seconds = header.stamp_ns / kSecond_ns, rest = header.stamp_ns % kSecond_ns;
  if (rest < 0) {
    --seconds;
    rest += kSecond_ns;
  }
  if (seconds < std::numeric_limits<std::int32_t>::min() ||
      seconds > std::numeric_limits<std::int32_t>::max()) {
    throw Error(
        ErrorKind::kInput,
        fmt::format("header stamp: found {} s, allowed what 32 bits hold: to the year 2038", seconds));
  }
  out.number(static_cast<std::int32_t>(seconds))
      .number(static_cast<std::uint32_t>(rest))
      .text(header.frame_id);
}

void put(CdrWriter& out, const Eigen::Vector3d& v) { out.number(v.x()).number(v.y()).number(v.z()); }

void put(CdrWriter& out, const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  put(out, pose.translation);
  out.number(q.x()).number(q.y()).number(q.z()).number(q.w());
}

Header read_header(CdrReader& in) {
  const auto seconds = in.number<std::int32_t>("header.stamp.sec");
  const auto rest = in.number<std::uint32_t>("header.stamp.nanosec");
  if (rest >= kSecond_ns) in.refuse("header.stamp.nanosec", fmt::format("{}", rest), "less than a second");
  return {seconds * kSecond_ns + rest, in.text("header.frame_id")};
}

/// Error of a message: field, found, allowed; no value if it is valid.
using Fault = std::optional<std::array<std::string, 3>>;

Fault read_pose(CdrReader& in, const char* position, const char* rotation, Pose& pose) {
  for (Eigen::Index i = 0; i < 3; ++i) pose.translation[i] = in.number<double>(position);
  std::array<double, 4> q{};
  in.all(q, rotation);
  pose.rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
  constexpr double kFarthest_m = 1e9;
  const bool is_near =
      pose.translation.array().isFinite().all() && pose.translation.cwiseAbs().maxCoeff() <= kFarthest_m;
  if (!is_near)
    return {{position, "values that are none or beyond", fmt::format("at most {} m", kFarthest_m)}};
  const double norm = pose.rotation.norm();
  constexpr double kOff = 1e-2;  // some recorders write floats
  if (!(std::abs(norm - 1.0) <= kOff)) return {{rotation, fmt::format("a norm of {}", norm), "1"}};
  pose.rotation.normalize();
  return {};
}

}  // namespace

std::size_t bytes_of(std::uint8_t datatype) {
  constexpr std::array<std::size_t, 9> kBytes{0, 1, 1, 2, 2, 4, 4, 4, 8};
  return datatype < kBytes.size() ? kBytes[datatype] : 0;
}

std::string to_cdr(const ImageMessage& m) {
  CdrWriter out;
  put(out, m.header);
  out.number(m.height).number(m.width).text(m.encoding);
  out.number(static_cast<std::uint8_t>(m.is_bigendian)).number(m.step).bytes(m.data);
  return out.message();
}

std::string to_cdr(const CompressedImageMessage& m) {
  CdrWriter out;
  put(out, m.header);
  out.text(m.format).bytes(m.data);
  return out.message();
}

std::string to_cdr(const CameraInfoMessage& m) {
  CdrWriter out;
  put(out, m.header);
  out.number(m.height).number(m.width).text(m.distortion_model).length(m.d.size());
  out.all(m.d).all(m.k).all(m.r).all(m.p).number(m.binning_x).number(m.binning_y);
  out.number(m.roi_x_offset).number(m.roi_y_offset).number(m.roi_height).number(m.roi_width);
  out.number(static_cast<std::uint8_t>(m.roi_do_rectify));
  return out.message();
}

std::string to_cdr(const PointCloudMessage& m) {
  CdrWriter out;
  put(out, m.header);
  out.number(m.height).number(m.width).length(m.fields.size());
  for (const PointField& field : m.fields)
    out.text(field.name).number(field.offset).number(field.datatype).number(field.count);
  out.number(static_cast<std::uint8_t>(m.is_bigendian)).number(m.point_step).number(m.row_step).bytes(m.data);
  out.number(static_cast<std::uint8_t>(m.is_dense));
  return out.message();
}

std::string to_cdr(const std::vector<TransformMessage>& transforms) {
  CdrWriter out;
  out.length(transforms.size());
  for (const TransformMessage& t : transforms) {
    put(out, t.header);
    out.text(t.child_frame_id);
    put(out, t.parent_from_child);
  }
  return out.message();
}

std::string to_cdr(const OdometryMessage& m) {
  CdrWriter out;
  put(out, m.header);
  out.text(m.child_frame_id);
  put(out, m.parent_from_child);
  constexpr std::array<double, 36> kUnknown{};
  constexpr std::array<double, 6> kTwist{};
  out.all(kUnknown).all(kTwist).all(kUnknown);
  return out.message();
}

std::string to_cdr(const std::vector<BoxMarker>& markers) {
  constexpr std::int32_t kCube = 1, kAdd = 0;
  CdrWriter out;
  out.length(markers.size());
  for (const BoxMarker& m : markers) {
    put(out, m.header);
    out.text(m.name).number(std::int32_t{0}).number(kCube).number(kAdd);
    put(out, m.frame_from_box);
    out.all(m.size_m).all(m.rgba);
    out.number(static_cast<std::int32_t>(m.lifetime_ns / kSecond_ns));
    out.number(static_cast<std::uint32_t>(m.lifetime_ns % kSecond_ns));
    out.number(std::uint8_t{0}).length(0).length(0);                   // frame_locked, points, colors
    out.text("");                                                      // texture_resource
    put(out, Header{});                                                // texture
    out.text("").bytes("").length(0);                                  // its format and data; uv_coordinates
    out.text("").text("").text("").bytes("").number(std::uint8_t{0});  // text, meshes
  }
  return out.message();
}

ImageMessage read_image_message(CdrReader in) {
  ImageMessage m;
  m.header = read_header(in);
  m.height = in.number<std::uint32_t>("height");
  m.width = in.number<std::uint32_t>("width");
  m.encoding = in.text("encoding");
  m.is_bigendian = in.number<std::uint8_t>("is_bigendian") != 0;
  m.step = in.number<std::uint32_t>("step");
  m.data = in.bytes("data");
  const std::uint64_t need = std::uint64_t{m.step} * m.height;
  if (m.data.size() < need)
    in.refuse("data",
              fmt::format("{} bytes", m.data.size()),
              fmt::format("{} x {} (step x height)", m.step, m.height));
  return m;
}

CompressedImageMessage read_compressed_image(CdrReader in) {
  CompressedImageMessage m;
  m.header = read_header(in);
  m.format = in.text("format");
  m.data = in.bytes("data");
  return m;
}

CameraInfoMessage read_camera_info(CdrReader in) {
  CameraInfoMessage m;
  m.header = read_header(in);
  m.height = in.number<std::uint32_t>("height");
  m.width = in.number<std::uint32_t>("width");
  m.distortion_model = in.text("distortion_model");
  m.d.resize(in.length("d", sizeof(double)));
  in.all(m.d, "d");
  in.all(m.k, "k");
  in.all(m.r, "r");
  in.all(m.p, "p");
  m.binning_x = in.number<std::uint32_t>("binning_x");
  m.binning_y = in.number<std::uint32_t>("binning_y");
  for (std::uint32_t* value : {&m.roi_x_offset, &m.roi_y_offset, &m.roi_height, &m.roi_width})
    *value = in.number<std::uint32_t>("roi");
  m.roi_do_rectify = in.number<std::uint8_t>("roi.do_rectify") != 0;
  return m;
}

PointCloudMessage read_point_cloud(CdrReader in) {
  PointCloudMessage m;
  m.header = read_header(in);
  m.height = in.number<std::uint32_t>("height");
  m.width = in.number<std::uint32_t>("width");
  constexpr std::size_t kLeastField = 4 + 4 + 1 + 4;
  m.fields.resize(in.length("fields", kLeastField));
  for (PointField& field : m.fields) {
    field.name = in.text("fields: name");
    field.offset = in.number<std::uint32_t>("fields: offset");
    field.datatype = in.number<std::uint8_t>("fields: datatype");
    field.count = in.number<std::uint32_t>("fields: count");
  }
  if (in.number<std::uint8_t>("is_bigendian") != 0) in.refuse("is_bigendian", "true", "false");
  m.point_step = in.number<std::uint32_t>("point_step");
  m.row_step = in.number<std::uint32_t>("row_step");
  m.data = in.bytes("data");
  m.is_dense = in.number<std::uint8_t>("is_dense") != 0;
  for (const PointField& field : m.fields) {
    const std::uint64_t size = bytes_of(field.datatype);
    if (size == 0)
      in.refuse("field " + field.name + ": datatype", fmt::format("{}", field.datatype), "1 to 8");
    if (std::uint64_t{field.offset} + size > m.point_step) {
      in.refuse("field " + field.name + ": offset",
                fmt::format("{}", field.offset),
                fmt::format("within the point_step of {}", m.point_step));
    }
  }
  if (m.width == 0 || m.height == 0) m.width = m.height = 0;  // no points
  if (m.width > 0 && m.point_step == 0) in.refuse("point_step", "0", "1 or more");
  const std::uint64_t row = std::uint64_t{m.width} * m.point_step;
  if (m.height <= 1 && m.row_step == 0) m.row_step = m.point_step * m.width;  // some drivers leave it 0
  if (m.row_step < row)
    in.refuse(
        "row_step", fmt::format("{}", m.row_step), fmt::format("at least {} (width x point_step)", row));
  if (m.height > 0 && std::uint64_t{m.row_step} * (m.height - 1) + row > m.data.size()) {
    in.refuse("data",
              fmt::format("{} bytes", m.data.size()),
              fmt::format("{} x {} (row_step x height)", m.row_step, m.height));
  }
  return m;
}

Header read_header_of(CdrReader in) { return read_header(in); }

std::vector<TransformMessage> read_transforms(CdrReader in, std::size_t& left_out) {
  constexpr std::size_t kLeast = 8 + 4 + 4 + 7 * sizeof(double);
  std::vector<TransformMessage> transforms;
  for (std::size_t left = in.length("transforms", kLeast); left > 0; --left) {
    TransformMessage t;
    t.header = read_header(in);
    t.child_frame_id = in.text("child_frame_id");
    if (read_pose(in, "translation", "rotation", t.parent_from_child)) {
      ++left_out;
    } else {
      transforms.push_back(std::move(t));
    }
  }
  return transforms;
}

OdometryMessage read_odometry(CdrReader in) {
  OdometryMessage m;
  m.header = read_header(in);
  m.child_frame_id = in.text("child_frame_id");
  if (const Fault fault = read_pose(in, "pose.position", "pose.orientation", m.parent_from_child))
    in.refuse((*fault)[0], (*fault)[1], (*fault)[2]);
  return m;
}

}  // namespace simuli::ros2
