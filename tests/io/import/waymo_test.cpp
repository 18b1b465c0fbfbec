#include "io/import/waymo/waymo.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "io/base/file.hpp"
#include "io/base/gzip.hpp"
#include "io/picture/image.hpp"
#include "tests/io/scratch.hpp"
#include "tests/io/survey.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::expect_survey;
using test::Scratch;

/// Writes a message field by field, with the numbers of the public schema.
class Message {
 public:
  Message& number(std::uint32_t field, std::uint64_t value) {
    varint(field << 3U);
    varint(value);
    return *this;
  }
  Message& bytes(std::uint32_t field, const std::string& value) {
    varint(field << 3U | 2U);
    varint(value.size());
    text_ += value;
    return *this;
  }
  Message& real(std::uint32_t field, double value) {
    varint(field << 3U | 1U);
    char eight[8];
    std::memcpy(eight, &value, 8);
    text_.append(eight, 8);
    return *this;
  }
  Message& reals(std::uint32_t field, const std::vector<double>& values) {
    for (const double value : values) real(field, value);
    return *this;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void varint(std::uint64_t value) {
    for (; value > 127; value >>= 7U) text_.push_back(static_cast<char>((value & 127U) | 128U));
    text_.push_back(static_cast<char>(value));
  }
  std::string text_;
};

std::string transform(double x, double y, double z, double yaw = 0.0) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  return Message().reals(1, {c, -s, 0, x, s, c, 0, y, 0, 0, 1, z, 0, 0, 0, 1}).text();
}

std::string record(const std::string& bytes) {
  std::string out(12, '\0');
  const std::uint64_t length = bytes.size();
  std::memcpy(out.data(), &length, 8);
  return out + bytes + std::string(4, '\0');
}

constexpr double kStart_s = 1'550'000'000.0;
constexpr int kRows = 4, kColumns = 8;

std::string range_image() {
  std::string values;
  for (int i = 0; i < kRows * kColumns; ++i) {
    // Range, intensity, elongation, in no-label zone. The first of a row has no return.
    for (const float v : {i % kColumns == 0 ? -1.0F : 10.0F + static_cast<float>(i), 0.5F, 0.0F, -1.0F}) {
      char four[4];
      std::memcpy(four, &v, 4);
      values.append(four, 4);
    }
  }
  const std::string shape = Message().number(1, kRows).number(1, kColumns).number(1, 4).text();
  return gzip(Message().bytes(1, values).bytes(2, shape).text());
}

/// Returns frame i at 0.1 i s: the vehicle moves at 10 m/s along x; one camera, TOP, a car 20 m ahead.
std::string frame(int i,
                  const std::string& picture,
                  const std::string& image = range_image(),
                  std::uint64_t read_out = 4) {
  const double t = kStart_s + 0.1 * i, x = 1000.0 + i;
  Message context;
  context.bytes(1, "segment-1");
  context.bytes(2,
                Message()
                    .number(1, 1)
                    .reals(2, {9, 10, 3.5, 2.5, 0.01, -0.02, 0.003, 0.001, 0.004})
                    .bytes(3, transform(1.5, 0.0, 2.0))
                    .number(4, 8)
                    .number(5, 6)
                    .number(6, read_out)
                    .text());
  context.bytes(3, Message().number(1, 2).text());
  context.bytes(3,
                Message()
                    .number(1, 1)
                    .reals(2, {-0.3, -0.1, 0.0, 0.02})
                    .bytes(5, transform(1.4, 0.0, 2.2, 0.5))
                    .text());
  const std::string top = Message().number(1, 1).bytes(2, Message().bytes(2, image).text()).text();
  const std::string box = Message()
                              .reals(1, {})
                              .real(1, 20.0)
                              .real(2, 0.0)
                              .real(3, 1.0)
                              .real(4, 1.9)
                              .real(5, 4.5)
                              .real(6, 1.6)
                              .real(7, 0.0)
                              .text();
  return Message()
      .bytes(1, context.text())
      .number(2, static_cast<std::uint64_t>(std::llround(t * 1e6)))
      .bytes(3, transform(x, 0.0, 0.0))
      .bytes(4,
             Message()
                 .number(1, 1)
                 .bytes(2, picture)
                 .bytes(3, transform(x + 0.5, 0.0, 0.0))
                 .real(5, t + 0.05)
                 .real(6, 0.004)
                 .real(7, t + 0.03)
                 .real(8, t + 0.064)
                 .text())
      .bytes(5, top)
      .bytes(6, Message().bytes(1, box).number(3, 1).bytes(4, "id").text())
      .number(99, 7)  // of a later version
      .text();
}

std::string some_picture(const Scratch& scratch) {
  write_image(scratch / "p.jpg", Image(8, 6, 3));
  return read_file(scratch / "p.jpg");
}

TEST(Waymo, ASegmentBecomesALog) {
  const Scratch scratch;
  std::string bytes;
  for (int i = 0; i < 3; ++i) bytes += record(frame(i, some_picture(scratch)));
  WaymoReport report;
  const Log log = import_waymo({scratch.file("s.tfrecord", bytes), scratch / "w.log"}, {}, report);
  WaymoReport surveyed;
  expect_survey(import_waymo({scratch / "s.tfrecord", ""}, {}, surveyed), log);
  EXPECT_EQ(surveyed.returned, report.returned);
  EXPECT_EQ(report.frames, 3U);
  EXPECT_EQ(report.rays, 3U * kRows * kColumns);
  EXPECT_EQ(report.returned, 3U * kRows * (kColumns - 1));
  EXPECT_EQ(log.name, "segment-1");
  const LogCamera& camera = log.camera("FRONT");
  EXPECT_EQ(camera.model.cx, 4.0);
  EXPECT_EQ(camera.model.shutter, ShutterKind::kRightToLeft);
  EXPECT_LT((camera.rig_from_camera.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(),
            1e-9);
  ASSERT_EQ(log.images.size(), 3U);
  EXPECT_NEAR(log.images[1].time_start_s, 0.132, 1e-6);  // the middle of the first column's exposure
  EXPECT_NEAR(log.images[1].time_end_s, 0.162, 1e-6);
  EXPECT_EQ(read_image(log.folder / log.images[2].file).width, 8);
  EXPECT_NEAR(log.world_from_rig.at(0.15).translation.x(), 1001.5, 1e-4);

  ASSERT_EQ(log.sweeps.size(), 3U);
  EXPECT_NEAR(log.sweeps[0].time_end_s, 0.1, 1e-6);
  EXPECT_NEAR(log.sweeps[2].time_end_s, 0.3, 1e-6);
  const Lidar& lidar = log.lidar("TOP").with_rows();
  EXPECT_EQ(lidar.rows[0].elevation, 0.02);
  // Column 0 points to the rear of the vehicle, although the sensor is rotated by 0.5.
  const double azimuth = lidar.azimuth(0, 0) + 0.5;
  EXPECT_NEAR(
      std::remainder(azimuth - std::numbers::pi * (1.0 - 1.0 / kColumns), 2.0 * std::numbers::pi), 0.0, 1e-9);
  const Sweep sweep = read_sweep(log.folder / log.sweeps[0].file, lidar);
  EXPECT_EQ(sweep.range[0], 0.0F);
  EXPECT_EQ(sweep.range[9], 19.0F);
  EXPECT_NEAR(sweep.intensity[9], std::tanh(0.5F), 1e-5);

  ASSERT_EQ(log.actors.size(), 1U);
  EXPECT_EQ(log.actors[0].kind, "vehicle");
  EXPECT_EQ(log.actors[0].size_m, Eigen::Vector3d(4.5, 1.9, 1.6));
  EXPECT_NEAR(log.actors[0].track.at(1).world_from_actor.translation.x(), 1021.0, 1e-9);
}

TEST(Waymo, LensesAndShuttersAreThoseOfTheirCalibration) {
  const Scratch scratch;
  const std::string picture = some_picture(scratch);
  constexpr ShutterKind kReadOut[] = {ShutterKind::kTopToBottom,
                                      ShutterKind::kLeftToRight,
                                      ShutterKind::kBottomToTop,
                                      ShutterKind::kRightToLeft,
                                      ShutterKind::kGlobal};
  for (std::uint64_t k = 0; k < std::size(kReadOut); ++k) {
    WaymoReport report;
    std::string bytes;
    for (int i = 0; i < 2; ++i) bytes += record(frame(i, picture, range_image(), k + 1));
    const fs::path file = scratch.file("s.tfrecord", bytes);
    const Log log = import_waymo({file, scratch / std::to_string(k)}, {}, report);
    const Camera& camera = log.camera("FRONT").model;
    EXPECT_EQ(camera.shutter, kReadOut[k]);
    const bool rolls = log.images[0].time_end_s > log.images[0].time_start_s;
    EXPECT_EQ(rolls, camera.shutter != ShutterKind::kGlobal) << k;
    // The data set's formula: f_u, f_v, c_u, c_v, k1, k2, p1, p2, k3; pixel centres are integers.
    const double x = 0.3, y = -0.2, r2 = x * x + y * y;
    const double radial = 1.0 + 0.01 * r2 - 0.02 * r2 * r2 + 0.004 * r2 * r2 * r2;
    const double u = x * radial + 2.0 * 0.003 * x * y + 0.001 * (r2 + 2.0 * x * x);
    const double v = y * radial + 0.003 * (r2 + 2.0 * y * y) + 2.0 * 0.001 * x * y;
    Eigen::Vector2d pixel;
    ASSERT_TRUE(camera.project({x, y, 1.0}, pixel));
    EXPECT_NEAR(pixel.x(), 9.0 * u + 4.0, 1e-9);
    EXPECT_NEAR(pixel.y(), 10.0 * v + 3.0, 1e-9);
  }
}

TEST(Waymo, RefusesWhatIsNotWhole) {
  const Scratch scratch;
  const std::string picture = some_picture(scratch);
  const std::string good = record(frame(0, picture));
  WaymoReport report;
  const auto refuse = [&](const std::string& bytes, const char* word) {
    expect_input_error(
        [&] {
          (void)import_waymo({scratch.file("b.tfrecord", bytes), scratch / "x.log"}, {}, report);
        },
        {"b.tfrecord", word});
    EXPECT_FALSE(fs::exists(scratch / "x.log"));
  };
  refuse("", "nothing to read");
  refuse("\xd4\xc3\xb2\xa1 of another program",
         "23 bytes that begin with no whole record, allowed a .tfrecord");
  refuse(good.substr(0, good.size() - 1), "record");
  refuse(good + "abc", "record");
  refuse(record(frame(0, picture).substr(0, 200)), "frame");
  refuse(record(frame(0, "")), "image");
  refuse(record(frame(0, picture, "no zlib")), "compressed data");
  refuse(record(frame(0, picture, gzip(Message().number(3, 1).text()))), "range image");
  const std::string pose = transform(1.5, 0.0, 2.0);
  std::string transposed = frame(0, picture);
  transposed.replace(transposed.find(pose),
                     pose.size(),
                     Message().reals(1, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1.5, 0, 2, 1}).text());
  refuse(record(transposed), "another last row");
  const auto refuse_path = [&](const fs::path& path, const char* found) {
    expect_input_error(
        [&] {
          (void)import_waymo({path, scratch / "x.log"}, {}, report);
        },
        {found, "allowed a .tfrecord of frames"});
  };
  refuse_path(scratch.path(), "found a folder");
  // A tf.Example: features by name. A Scenario: times, then tracks in place of a frame's time.
  const std::string feature = Message().bytes(1, "state/current/x").bytes(2, "").text();
  refuse(record(Message().bytes(1, Message().bytes(1, feature).text()).text()), "Motion data set");
  refuse(record(Message().bytes(5, "id").reals(1, {0.0, 0.1}).bytes(2, Message().number(1, 7).text()).text()),
         "Motion data set");
  refuse_path(scratch / "nowhere", "found no such file");
}

}  // namespace
}  // namespace simuli
