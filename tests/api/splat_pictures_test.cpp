// The same model from two files of different formats looks the same.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <iostream>

#include "host/device/render/scene/scene_on_device.hpp"
#include "io/base/gzip.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

Image picture_of_splats(const Device& device, const fs::path& file) {
  Scene scene;
  scene.camera = read_splats(file);
  scene.camera_background = {0.5F, 0.5F, 0.5F};
  SceneOnDevice on_device(device, std::move(scene));
  // The biker stands 3 m tall on y = 0, y down: seen from 4.5 m in front.
  const Sensor camera(Camera{"any", 480, 480, 480.0, 480.0, 240.0, 240.0});
  return on_device.render(camera, Shot::at({Eigen::Quaterniond::Identity(), {0.0, -1.6, -4.5}}, 0.0)).image();
}

TEST(SplatPictures, SpzAndCompressedPlyOfOneModelAreAlike) {
  const char* const data = std::getenv("SIMULI_DATA");
  if (data == nullptr) GTEST_SKIP() << "not run: models of PlayCanvas as SPZ and PLY, SIMULI_DATA is not set";
  if (!has_zstd()) GTEST_SKIP() << "not run: SPZ version 4, this build has no libzstd";
  const fs::path folder = fs::path(data) / "splats" / "playcanvas";
  const Device device = Device::best();
  const Image spz = picture_of_splats(device, folder / "biker.spz");
  const Image ply = picture_of_splats(device, folder / "biker.compressed.ply");
  double square = 0.0;
  std::size_t values = 0;  // that show the model, not the background
  for (std::size_t i = 0; i < spz.data.size(); ++i) {
    if (std::abs(spz.data[i] - 0.5F) < 0.02F && std::abs(ply.data[i] - 0.5F) < 0.02F) continue;
    square += std::pow(static_cast<double>(spz.data[i] - ply.data[i]), 2.0);
    ++values;
  }
  EXPECT_GT(values, spz.data.size() / 20);
  const double psnr_db = -10.0 * std::log10(square / static_cast<double>(values));
  std::cout << "PSNR " << psnr_db << " dB on " << values << " values\n";
  // Both quantise: scales by 1/16, colours and opacities by 1/255.
  EXPECT_GT(psnr_db, 40.0);
}

}  // namespace
}  // namespace simuli
