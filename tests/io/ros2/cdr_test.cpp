// Tests messages against bytes written manually from CDR and the message definitions.
#include "io/ros2/cdr.hpp"

#include <gtest/gtest.h>
#include <string>

#include "io/ros2/camera_info.hpp"
#include "io/ros2/messages.hpp"
#include "tests/host/windshields.hpp"
#include "tests/io/scratch.hpp"

namespace simuli::ros2 {
namespace {

using test::expect_input_error;

/// Returns the bytes of "01 ff 'ab' ..": hexadecimal numbers and text.
std::string bytes(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == ' ') continue;
    if (text[i] == '\'') {
      for (++i; text[i] != '\''; ++i) out += text[i];
    } else {
      out += static_cast<char>(std::stoi(text.substr(i, 2), nullptr, 16));
      ++i;
    }
  }
  return out;
}

const std::string kHead = "00 01 00 00 ";
const std::string kStamp = "07 00 00 00  02 00 00 00 ";  // 7 s and 2 ns
constexpr std::int64_t kStamp_ns = 7'000'000'002;
const std::string kOne = "00 00 00 00 00 00 f0 3f ", kTwo = "00 00 00 00 00 00 00 40 ",
                  kZero = "00 00 00 00 00 00 00 00 ";

CdrReader reader(const std::string& message) { return {message, "drive.mcap", "/topic"}; }

/// Expects a one-line error for each truncation of the message.
template <class Read>
void expect_whole_or_refused(const std::string& message, const Read& read) {
  for (std::size_t size = 0; size < message.size(); ++size) {
    SCOPED_TRACE(size);
    const std::string part = message.substr(0, size);
    expect_input_error([&] { (void)read(CdrReader(part, "drive.mcap", "/topic")); },
                       {"drive.mcap", "/topic"});
  }
}

TEST(Cdr, TransformsAreThoseBytes) {
  const std::string golden = bytes(kHead + "01 00 00 00" + kStamp +
                                   "04 00 00 00 'map' 00  0a 00 00 00 'base_link' 00  00 00 00 00 00 00" +
                                   kOne + kTwo + kZero + kZero + kZero + kZero + kOne);
  const std::vector<TransformMessage> transforms{
      {{kStamp_ns, "map"}, "base_link", {Eigen::Quaterniond::Identity(), {1.0, 2.0, 0.0}}}};
  EXPECT_EQ(to_cdr(transforms), golden);
  std::size_t left_out = 0;
  const auto transforms_of = [&](CdrReader in) { return read_transforms(in, left_out); };
  const auto back = transforms_of(reader(golden));
  EXPECT_EQ(left_out, 0U);
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].header.stamp_ns, kStamp_ns);
  EXPECT_EQ(back[0].header.frame_id, "map");
  EXPECT_EQ(back[0].child_frame_id, "base_link");
  EXPECT_EQ(back[0].parent_from_child.translation, Eigen::Vector3d(1.0, 2.0, 0.0));
  expect_whole_or_refused(golden, transforms_of);
  std::string turned = golden;
  turned.back() = '\x40';  // a quaternion of norm 2
  left_out = 0;
  EXPECT_EQ(transforms_of(reader(turned)).size() + left_out, back.size());
  EXPECT_EQ(left_out, 1U);  // tf2 also ignores it
}

TEST(Cdr, CloudsAreThoseBytes) {
  const std::string golden =
      bytes(kHead + kStamp + "03 00 00 00 'os' 00 00  01 00 00 00  01 00 00 00 " +
            "01 00 00 00  02 00 00 00 'x' 00 00 00  00 00 00 00  07 00 00 00  01 00 00 00 " +
            "00 00 00 00  04 00 00 00  04 00 00 00  04 00 00 00 00 00 80 3f  01");
  PointCloudMessage cloud;
  cloud.header = {kStamp_ns, "os"};
  cloud.height = cloud.width = 1;
  cloud.fields = {{"x", 0, PointField::kFloat32}};
  cloud.point_step = cloud.row_step = 4;
  const std::string data = bytes("00 00 80 3f");
  cloud.data = data;
  EXPECT_EQ(to_cdr(cloud), golden);
  const PointCloudMessage back = read_point_cloud(reader(golden));
  EXPECT_EQ(back.data, data);
  EXPECT_EQ(back.fields.at(0).name, "x");
  expect_whole_or_refused(golden, read_point_cloud);
  const auto refused = [&](auto change, const std::vector<std::string>& words) {
    PointCloudMessage other = cloud;
    change(other);
    const std::string message = to_cdr(other);
    expect_input_error([&] { (void)read_point_cloud(reader(message)); }, words);
  };
  refused([](auto& c) { c.width = 2; }, {"row_step", "at least 8"});
  refused([](auto& c) { c.height = 1000; }, {"data", "4 x 1000"});
  refused([](auto& c) { c.point_step = 3; }, {"field x: offset"});
  refused([](auto& c) { c.fields[0].datatype = 9; }, {"field x: datatype", "9"});
  refused([](auto& c) { c.is_bigendian = true; }, {"is_bigendian"});
  // Points of zero bytes could be any number of points.
  refused(
      [](auto& c) {
        c.fields.clear();
        c.point_step = 0;
        c.width = 1'000'000'000;
      },
      {"point_step", "0", "1 or more"});
  PointCloudMessage none = cloud;
  none.width = none.row_step = 0;
  none.height = 4'000'000'000;
  none.data = {};
  const std::string message = to_cdr(none);
  EXPECT_EQ(read_point_cloud(reader(message)).height, 0U);
}

TEST(Cdr, PicturesAreThoseBytes) {
  const std::string golden = bytes(kHead + kStamp + "02 00 00 00 'f' 00 00 00  01 00 00 00  02 00 00 00 " +
                                   "06 00 00 00 'mono8' 00  00 00  02 00 00 00  02 00 00 00 10 20");
  // After the encoding (6 bytes to offset 34) is_bigendian is one byte; step is at a multiple of four.
  ImageMessage image{{kStamp_ns, "f"}, 1, 2, "mono8", false, 2, "\x10\x20"};
  EXPECT_EQ(to_cdr(image), golden);
  const ImageMessage back = read_image_message(reader(golden));
  EXPECT_EQ(back.data, image.data);
  EXPECT_EQ(back.step, 2U);
  expect_whole_or_refused(golden, read_image_message);
  image.step = 3;
  const std::string short_rows = to_cdr(image);
  expect_input_error([&] { (void)read_image_message(reader(short_rows)); }, {"data", "3 x 1"});
}

TEST(Cdr, CameraInfoIsThoseBytes) {
  Camera camera;
  camera.name = "front";
  camera.width = 4;
  camera.height = 2;
  camera.fx = camera.fy = 1.0;
  camera.cx = 2.5;  // there, pixel centres are integers
  camera.cy = 0.5;
  std::string golden = kHead + kStamp + "02 00 00 00 'f' 00 00 00  02 00 00 00  04 00 00 00 " +
                       "0a 00 00 00 'plumb_bob' 00 00 00  05 00 00 00  00 00 00 00 ";
  for (int i = 0; i < 5; ++i) golden += kZero;
  golden += kOne + kZero + kTwo + kZero + kOne + kZero + kZero + kZero + kOne;                          // k
  golden += kOne + kZero + kZero + kZero + kOne + kZero + kZero + kZero + kOne;                         // r
  golden += kOne + kZero + kTwo + kZero + kZero + kOne + kZero + kZero + kZero + kZero + kOne + kZero;  // p
  golden += "00 00 00 00  00 00 00 00  00 00 00 00  00 00 00 00  00 00 00 00  00 00 00 00  00";
  CameraInfoMessage info = camera_info_of(camera);
  info.header = {kStamp_ns, "f"};
  EXPECT_EQ(to_cdr(info), bytes(golden));
  const CameraInfoMessage back = read_camera_info(reader(bytes(golden)));
  EXPECT_EQ(camera_of(back, "front", "drive.mcap", "/info"), camera);
  expect_whole_or_refused(bytes(golden), read_camera_info);
}

TEST(Cdr, LensesComeBack) {
  Camera camera = builtin_camera("tum_vi_cam0");
  const auto there_and_back = [&](const Lens& lens) {
    camera.lens = lens;
    const CameraInfoMessage info = camera_info_of(camera);
    const Camera back = camera_of(info, camera.name, "drive.mcap", "/info");
    EXPECT_EQ(back.lens, lens) << info.distortion_model;
    EXPECT_DOUBLE_EQ(back.cx, camera.cx);
    return info.distortion_model;
  };
  const double pi = 3.141592653589793;
  EXPECT_EQ(
      there_and_back(Lens(LensKind::kOpencvPinhole, {0.1, 0.01, 1e-3, 1e-3, 0.001, 0, 0, 0, 0, 0, 0, 0, pi})),
      "plumb_bob");
  EXPECT_EQ(there_and_back(Lens(LensKind::kOpencvPinhole, {0.1, 0.01, 0, 0, 0, 0.01, 0, 0, 0, 0, 0, 0, pi})),
            "rational_polynomial");
  EXPECT_EQ(there_and_back(Lens(LensKind::kOpencvFisheye, {0.01, 0.001, 0, 0, pi})), "equidistant");
  EXPECT_EQ(there_and_back(Lens(LensKind::kOpencvPinhole, {0.1, 0, 0, 0, 0, 0, 0, 0, 1e-3, 0, 0, 0, pi})),
            "opencv_pinhole");
  EXPECT_EQ(there_and_back(Lens(LensKind::kDoubleSphere, {0.1, 0.5, 1.0})), "double_sphere");
  EXPECT_EQ(there_and_back(Lens().behind(test::glass_before_the_lens())), "opencv_pinhole_behind_windshield");
  EXPECT_EQ(
      there_and_back(Lens(LensKind::kDoubleSphere, {0.1, 0.5, 1.0}).behind(test::glass_by_its_way_back())),
      "double_sphere_behind_windshield");
  CameraInfoMessage info = camera_info_of(camera);
  // OpenCV's vector of any length with either name; missing values are zero.
  for (const char* name : {"plumb_bob", "rational_polynomial"}) {
    info.distortion_model = name;
    for (const std::size_t count : {4U, 5U, 8U, 12U, 14U}) {
      info.d.assign(count, 0.0);
      info.d[0] = 0.1;
      if (count > 8) info.d[8] = 1e-3;  // thin prism
      const Lens lens = camera_of(info, "c", "drive.mcap", "/info").lens;
      EXPECT_EQ(lens.kind(), LensKind::kOpencvPinhole);
      EXPECT_EQ(lens.parameters()[0], 0.1);
      EXPECT_EQ(lens.parameters()[8], count > 8 ? 1e-3 : 0.0);
    }
    info.d.back() = 0.01;
    expect_input_error([&] { (void)camera_of(info, "c", "drive.mcap", "/info"); }, {"/info: d", "tilted"});
    info.d.pop_back();
    expect_input_error([&] { (void)camera_of(info, "c", "drive.mcap", "/info"); },
                       {"13 values", "4, 5, 8, 12"});
    info.d.assign(14, 0.0);
    EXPECT_EQ(camera_of(info, "c", "drive.mcap", "/info").lens.kind(), LensKind::kPinhole);
  }
  info.distortion_model = "none";
  EXPECT_EQ(camera_of(info, "c", "drive.mcap", "/info").lens.kind(), LensKind::kPinhole);
  info.distortion_model = "fisheye";
  info.d = {0.01, 0.001, 0.0, 0.0};
  EXPECT_EQ(camera_of(info, "c", "drive.mcap", "/info").lens.kind(), LensKind::kOpencvFisheye);
  info = camera_info_of(camera);
  const auto refused = [&](const std::vector<std::string>& words) {
    expect_input_error([&] { (void)camera_of(info, "c", "drive.mcap", "/info"); }, words);
  };
  camera.lens = Lens().behind(test::glass_before_the_lens());
  const CameraInfoMessage behind = camera_info_of(camera);
  for (const std::size_t count : {std::size_t{3}, std::size_t{14}, behind.d.size() - 1}) {
    info = behind;
    info.d.resize(count);
    refused({"/info", "d", "those of a lens and of a windshield"});
  }
  info.distortion_model = "cylindrical_behind_windshield";
  refused({"cylindrical"});
  info.distortion_model = "cylindrical";
  refused({"/info", "distortion_model", "cylindrical", "plumb_bob"});
  info.distortion_model = "equidistant";
  info.d = {1.0, 2.0};
  refused({"d", "2 values", "4 of equidistant"});
  info.roi_width = 2;
  refused({"roi"});
  info.binning_x = 2;
  refused({"binning", "2 x 0"});
}

TEST(Cdr, OtherEncodingsAreRefused) {
  const std::string big_endian = bytes("00 00 00 00 00 00 00 00");
  expect_input_error([&] { (void)reader(big_endian); }, {"first bytes", "CDR"});
  const std::string endless = bytes(kHead + "ff ff ff ff");  // four billion transforms without data
  std::size_t left_out = 0;
  expect_input_error([&] { (void)read_transforms(reader(endless), left_out); }, {"transforms", "4294967295"});
}

}  // namespace
}  // namespace simuli::ros2
