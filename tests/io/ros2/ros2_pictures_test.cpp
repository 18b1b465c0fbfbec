// Tests pictures of ROS 2 in the encodings of cameras, and cameras with a lens from a file.
#include <array>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <string>

#include "io/bag/mcap_writer.hpp"
#include "io/import/ros2/ros2_frames.hpp"
#include "io/ros2/messages.hpp"
#include "tests/io/ros2/ros2_street.hpp"

namespace simuli {
namespace ros2_pictures_test {

using namespace test;  // NOLINT(google-build-using-namespace)

ros2::ImageMessage message_of(
    const char* encoding, int width, int height, int step, const std::string& data) {
  ros2::ImageMessage message;
  message.header = {kStart_ns, "camera"};
  message.encoding = encoding;
  message.width = static_cast<std::uint32_t>(width);
  message.height = static_cast<std::uint32_t>(height);
  message.step = static_cast<std::uint32_t>(step);
  message.data = data;
  return message;
}

/// Returns `bytes` repeated.
std::string repeated(std::initializer_list<int> bytes, std::size_t count) {
  std::string out;
  while (out.size() < count) {
    for (const int b : bytes) out += static_cast<char>(b);
  }
  return out;
}

TEST(Ros2Pictures, EncodingsBecomeColours) {
  // One colour all over, 4 x 4 pixels: red 200, green 100, blue 50, or grey 100.
  constexpr int kR = 200, kG = 100, kB = 50;
  const auto rows = [](std::initializer_list<int> even, std::initializer_list<int> odd) {
    std::string out;
    for (int y = 0; y < 4; ++y) out += repeated(y % 2 == 0 ? even : odd, 4);
    return out;
  };
  // This colour in BT.601: luma 123, U 91, V 175.
  constexpr int kY = 123, kU = 91, kV = 175;
  struct Case {
    const char* encoding;
    int step;
    std::string data;
    bool is_grey = false, is_bigendian = false;
    double tolerance = 1e-6;
  };
  const std::string luma = repeated({kY}, 16);
  for (const Case& c : {
           Case{"rgb8", 12, repeated({kR, kG, kB}, 48)},
           Case{"bgra8", 16, repeated({kB, kG, kR, 7}, 64)},
           Case{"8UC3", 12, repeated({kB, kG, kR}, 48)},
           Case{"8UC4", 16, repeated({kB, kG, kR, 7}, 64)},
           Case{"8UC1", 4, repeated({kG}, 16), true},
           Case{"mono8", 4, repeated({kG}, 16), true},
           Case{"mono16", 8, repeated({kG, kG}, 32), true},
           Case{"mono16", 8, repeated({0, kG}, 32), true, false, 4e-3},
           Case{"mono16", 8, repeated({kG, 0}, 32), true, true, 4e-3},
           Case{"rgb16", 24, repeated({kR, kR, kG, kG, kB, kB}, 96)},
           Case{"bgr16", 24, repeated({kB, kB, kG, kG, kR, kR}, 96)},
           Case{"bgra16", 32, repeated({kB, kB, kG, kG, kR, kR, 1, 1}, 128)},
           Case{"bayer_rggb8", 4, rows({kR, kG}, {kG, kB})},
           Case{"bayer_bggr8", 4, rows({kB, kG}, {kG, kR})},
           Case{"bayer_gbrg8", 4, rows({kG, kB}, {kR, kG})},
           Case{"bayer_grbg8", 4, rows({kG, kR}, {kB, kG})},
           Case{"yuv422", 8, repeated({kU, kY, kV, kY}, 32), false, false, 0.01},
           Case{"uyvy", 8, repeated({kU, kY, kV, kY}, 32), false, false, 0.01},
           Case{"yuv422_yuy2", 8, repeated({kY, kU, kY, kV}, 32), false, false, 0.01},
           Case{"yuyv", 8, repeated({kY, kU, kY, kV}, 32), false, false, 0.01},
           Case{"nv12", 4, luma + repeated({kU, kV}, 8), false, false, 0.01},
           Case{"nv21", 4, luma + repeated({kV, kU}, 8), false, false, 0.01},
       }) {
    SCOPED_TRACE(c.encoding);
    ros2::ImageMessage message = message_of(c.encoding, 4, 4, c.step, c.data);
    message.is_bigendian = c.is_bigendian;
    const Image image = ros2::picture_of(message, "a.mcap", "/front/image_raw");
    ASSERT_EQ(image.data.size(), 48U);
    for (std::size_t i = 0; i < image.data.size(); ++i) {
      const double want = (c.is_grey ? kG : std::array{kR, kG, kB}[i % 3]) / 255.0;
      ASSERT_NEAR(static_cast<double>(image.data[i]), want, c.tolerance) << i;
    }
    // A truncated row or picture is rejected.
    message.data = message.data.substr(0, message.data.size() - 1);
    expect_input_error([&] { (void)ros2::picture_of(message, "a.mcap", "/front/image_raw"); },
                       {"data", "bytes"});
    message.step -= 1;
    expect_input_error([&] { (void)ros2::picture_of(message, "a.mcap", "/front/image_raw"); }, {"step"});
  }
}

TEST(Ros2Pictures, AMosaicTakesWhatStandsBeside) {
  // Rows of R G R G over G B G B.
  const std::string data("\x0a\x14\x1e\x28\x32\x3c\x46\x50\x5a\x64\x6e\x78\x82\x8c\x96\xa0", 16);
  const Image image = ros2::picture_of(message_of("bayer_rggb8", 4, 4, 4, data), "a.mcap", "/front");
  const auto at = [&](int x, int y, int c) {
    return 255.0 * static_cast<double>(image.data[static_cast<std::size_t>((y * 4 + x) * 3 + c)]);
  };
  EXPECT_NEAR(at(2, 2, 0), 110.0, 1e-3);                               // its own
  EXPECT_NEAR(at(2, 2, 1), (70.0 + 100.0 + 120.0 + 150.0) / 4, 1e-3);  // above, left, right, below
  EXPECT_NEAR(at(2, 2, 2), (60.0 + 80.0 + 140.0 + 160.0) / 4, 1e-3);   // at its corners
  EXPECT_NEAR(at(2, 1, 0), (30.0 + 110.0) / 2, 1e-3);
  EXPECT_NEAR(at(2, 1, 2), (60.0 + 80.0) / 2, 1e-3);
  EXPECT_NEAR(at(0, 0, 1), (20.0 + 50.0) / 2, 1e-3);  // at the edge only existing neighbours
}

TEST(Ros2Pictures, OthersAreRefused) {
  const std::string data(256, 'x');
  const auto refused = [&](const char* encoding, int width, int height, std::vector<std::string> words) {
    words.emplace_back("a.mcap: /front");
    expect_input_error(
        [&] { (void)ros2::picture_of(message_of(encoding, width, height, 16, data), "a.mcap", "/front"); },
        words);
  };
  refused("32FC1", 4, 4, {"encoding", "32FC1", "rgb8", "bayer_rggb8", "nv12"});
  refused("16UC1", 4, 4, {"encoding"});  // usually depth
  refused("yuyv", 3, 4, {"3 x 4", "even"});
  refused("nv12", 4, 3, {"4 x 3", "even"});
  refused("rgb8", 0, 4, {"width x height"});
}

TEST(Ros2Pictures, AFileTellsALens) {
  const Scratch scratch;
  const std::string pixels(48, 'x');
  McapWriter mcap(scratch / "a.mcap", "ros2", McapWriter::Compression::kNone);
  for (const char* topic : {"/left/image_raw", "/right/image_raw"}) {
    const auto channel = mcap.add_channel({topic, ros2::kImage, "", "", "cdr"});
    mcap.add_message(channel, kStart_ns, ros2::to_cdr(message_of("mono8", 8, 6, 8, pixels)));
  }
  // An unusable CameraInfo, which is ignored.
  ros2::CameraInfoMessage info;
  info.header = {kStart_ns, "camera"};
  info.distortion_model = "unheard_of";
  mcap.add_message(mcap.add_channel({"/left/camera_info", ros2::kCameraInfo, "", "", "cdr"}),
                   kStart_ns,
                   ros2::to_cdr(info));
  mcap.finish();
  Ros2Options options;
  options.recording = scratch / "a.mcap";
  options.output = scratch / "a.log";
  options.without_poses = true;
  options.mounts["/left/image_raw"] = {};
  CameraFile file;
  file.model.name = "calibrated";
  file.model.width = 8;
  file.model.height = 6;
  file.model.fx = file.model.fy = 7.0;
  file.model.cx = 4.0;
  file.model.cy = 3.0;
  file.model.shutter = ShutterKind::kTopToBottom;
  file.readout_s = 0.02;
  options.lenses["/left/image_raw"] = file;
  Ros2Report report;
  const Log log = imported(options, report);
  ASSERT_EQ(log.cameras.size(), 1U);
  EXPECT_EQ(log.cameras[0].model.name, "left");
  EXPECT_EQ(log.cameras[0].model.fx, 7.0);
  EXPECT_EQ(log.cameras[0].model.shutter, ShutterKind::kTopToBottom);
  EXPECT_NEAR(log.images.at(0).time_end_s - log.images.at(0).time_start_s, 0.02, 1e-9);

  options.output = scratch / "b.log";
  options.lenses["/left/image_raw"].model.width = 9;
  expect_input_error([&] { (void)imported(options, report); },
                     {"/left/image_raw", "8 x 6", "9 x 6", "--camera"});
  options.lenses = {{"/rear/image_raw", file}};
  expect_error(
      ErrorKind::kUsage, [&] { (void)imported(options, report); }, {"--camera", "/rear", "/left/image_raw"});
  options.lenses.clear();
  options.ignore = {"/left/camera_info"};
  report = {};
  expect_error(ErrorKind::kNothing,
               [&] { (void)imported(options, report); },
               {"a.mcap", "sensors", "left out: /left/image_raw"});
  EXPECT_FALSE(std::filesystem::exists(options.output));
}

TEST(Ros2Pictures, DepthAndDamageAreLeftOut) {
  const Scratch scratch;
  const std::string pixels(48, 'x');
  McapWriter mcap(scratch / "a.mcap", "ros2", McapWriter::Compression::kNone);
  const auto channel = [&](const char* topic, const char* type) {
    return mcap.add_channel({topic, type, "", "", "cdr"});
  };
  ros2::CameraInfoMessage info;
  info.header = {kStart_ns, "camera"};
  info.width = 8;
  info.height = 6;
  info.k = {7.0, 0.0, 4.0, 0.0, 7.0, 3.0, 0.0, 0.0, 1.0};
  for (const char* topic : {"/front/camera_info", "/depth/camera_info", "/packed/camera_info"})
    mcap.add_message(channel(topic, ros2::kCameraInfo), kStart_ns, ros2::to_cdr(info));
  const auto front = channel("/front/image_raw", ros2::kImage);
  mcap.add_message(front, kStart_ns, ros2::to_cdr(message_of("mono8", 8, 6, 8, pixels.substr(1))));
  mcap.add_message(front, kStart_ns, ros2::to_cdr(message_of("mono8", 8, 6, 8, pixels)));
  mcap.add_message(channel("/depth/image_raw", ros2::kImage),
                   kStart_ns,
                   ros2::to_cdr(message_of("16UC1", 8, 6, 16, pixels + pixels)));
  ros2::CompressedImageMessage packed{{kStart_ns, "camera"}, "h264", pixels};
  mcap.add_message(channel("/packed/compressed", ros2::kCompressedImage), kStart_ns, ros2::to_cdr(packed));
  mcap.finish();
  Ros2Options options;
  options.recording = scratch / "a.mcap";
  options.output = scratch / "a.log";
  options.without_poses = true;
  options.mounts["/front/image_raw"] = {};
  Ros2Report report;
  EXPECT_EQ(imported(options, report).images.size(), 1U);
  const std::string reported = fmt::format("{}", fmt::join(report.notes, "\n"));
  for (const char* word : {"left out: 1 of 2 messages of /front/image_raw: ",
                           "left out: /depth/image_raw, pictures of encoding \"16UC1\"",
                           "left out: /packed/compressed, pictures of format \"h264\""})
    EXPECT_NE(reported.find(word), std::string::npos) << word << " is missing in: " << reported;
  // A requested camera without a valid model is an error, and so is a recording without any valid sensor.
  options.output = scratch / "b.log";
  options.cameras = {"/depth/image_raw"};
  expect_input_error([&] { (void)imported(options, report); }, {"/depth/image_raw", "16UC1"});
}

}  // namespace ros2_pictures_test
}  // namespace simuli
