#pragma once
// A street for trainings of a second.
#include <filesystem>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "io/synth/street.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/init/initialize.hpp"
#include "tests/support/device.hpp"

namespace simuli::test {

/// Returns the scene with the log's sensors.
inline SceneFile file_of(const Log& log, Scene scene) {
  return {std::move(scene), log.cameras, log.lidars, log.world_from_rig, frame_spans(log)};
}
inline EvalReport compare(const Log& log, const Scene& scene, const EvalOptions& options) {
  return Evaluation(test::device(), file_of(log, scene), log, options).run();
}

/// Six pictures of 64 x 36 and six sweeps of 32 x 90, generated once per process; frame 4 is held out.
class SmallStreet : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (std::filesystem::temp_directory_path() / "simuli_street_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    StreetOptions options;
    options.output = folder_ / "street.log";
    options.frames = 6;
    options.image_width = 64;
    options.image_height = 36;
    options.lidar_columns = 90;
    options.moving_car = false;
    log_ = synth_street(options);
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }

  static constexpr FrameSelection kFullSize{.image_scale = 1.0};
  static Scene initial_scene() {
    InitOptions options;
    options.voxel_m = 0.2;
    options.sweep_depth = false;
    return initialize_scene(log_, kFullSize, options).scene;
  }

  inline static std::filesystem::path folder_;
  inline static Log log_;
};

}  // namespace simuli::test
