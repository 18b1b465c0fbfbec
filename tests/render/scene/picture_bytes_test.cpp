#include "host/device/render/outputs/picture_bytes.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "host/core/base/error.hpp"
#include "io/picture/image.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/render/scene/wall_and_actor.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::at_origin;

std::string rounded(const Frame& frame, PixelOrder order) {
  const RayResults& results = frame.results();
  std::string bytes(3 * results.rays, '\0');
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<unsigned char> channel(results.rays);
    to_bytes(results.feature[c], channel);
    for (std::size_t i = 0; i < results.rays; ++i) {
      bytes[order == PixelOrder::kPlanar ? c * results.rays + i : 3 * i + c] = static_cast<char>(channel[i]);
    }
  }
  return bytes;
}

/// Sizes with and without partial tiles; each frame reuses the previous buffer.
TEST(PictureBytes, AreThoseOfTheResults) {
  for (const Precision precision : {Precision::kFloat, Precision::kDouble}) {
    const Device& device = test::device();
    if (precision == Precision::kDouble && !device.info().fp64) continue;
    RenderOptions options;
    options.precision = precision;
    Scene seen = test::wall_and_actor();
    seen.camera_background = {0.25F, 1.5F, -0.5F};
    SceneOnDevice scene(device, seen, options);
    PictureBytes bytes(device);
    for (const auto& [width, height] :
         {std::pair(48, 32), std::pair(45, 29), std::pair(5, 70), std::pair(64, 16)}) {
      const Sensor sensor(test::small_camera(width, height), test::forward_from_camera());
      const Frame frame = scene.render(sensor, at_origin(sensor));
      ByteDownload planar = bytes.start(frame, PixelOrder::kPlanar);
      ByteDownload interleaved = bytes.start(frame, PixelOrder::kInterleaved);
      const Frame other = scene.render(test::still_camera(), at_origin(sensor));
      EXPECT_EQ(planar.take(), rounded(frame, PixelOrder::kPlanar)) << width << " x " << height;
      EXPECT_EQ(interleaved.take(), rounded(frame, PixelOrder::kInterleaved)) << width << " x " << height;
    }
  }
}

/// All values halfway between steps and their neighbours; NaN.
TEST(PictureBytes, RoundAsFilesDo) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinite = std::numeric_limits<float>::infinity();
  std::vector<float> values{nan, infinite, -infinite, -0.0F, 1e-40F, 2.0F};
  for (int k = 0; k <= 255; ++k) {
    for (const float at : {(static_cast<float>(k) + 0.5F) / 255.0F, static_cast<float>(k) / 255.0F}) {
      values.insert(values.end(), {at, std::nextafter(at, 0.0F), std::nextafter(at, 2.0F)});
    }
  }
  const Device& device = test::device();
  PictureBytes bytes(device);
  Scene nothing;
  SceneOnDevice scene(device, nothing);
  const Sensor sensor(test::small_camera(1, 1), test::forward_from_camera());
  for (std::size_t i = 0; i + 2 < values.size(); i += 3) {
    nothing.camera_background = {values[i], values[i + 1], values[i + 2]};
    scene.set_scene(nothing);
    const Frame frame = scene.render(sensor, at_origin(sensor));
    EXPECT_EQ(bytes.start(frame, PixelOrder::kPlanar).take(), rounded(frame, PixelOrder::kPlanar))
        << values[i];
  }
}

TEST(PictureBytes, AreOfCamerasAlone) {
  const Device& device = test::device();
  SceneOnDevice scene(device, test::wall_and_actor());
  const Frame frame = scene.render(test::still_lidar(), at_origin(test::still_lidar()));
  PictureBytes bytes(device);
  expect_error(ErrorKind::kUsage, "allowed a camera", [&] {
    static_cast<void>(bytes.start(frame, PixelOrder::kPlanar));
  });
}

}  // namespace
}  // namespace simuli
