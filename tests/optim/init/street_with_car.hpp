#pragma once
// A small street with a moving car.
#include <filesystem>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "io/synth/street.hpp"
#include "optim/init/init_options.hpp"

namespace simuli::test {

class StreetWithCar : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (std::filesystem::temp_directory_path() / "simuli_car_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    StreetOptions options;
    options.output = folder_ / "street.log";
    options.frames = 10;
    options.image_width = 96;
    options.image_height = 54;
    options.lidar_columns = 450;
    log_ = synth_street(options);
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }

  static constexpr FrameSelection kFullSize{.image_scale = 1.0};
  static InitOptions small(bool actors) {
    InitOptions options;
    options.voxel_m = 0.15;
    options.sweep_depth = false;
    options.camera_sh_degree = 0;
    options.lidar_sh_degree = 0;
    options.actors = actors;
    return options;
  }

  inline static std::filesystem::path folder_;
  inline static Log log_;
};

}  // namespace simuli::test
