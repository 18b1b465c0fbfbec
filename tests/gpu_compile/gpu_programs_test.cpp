#include "tests/gpu_compile/gpu_programs.hpp"

#include <gtest/gtest.h>
#include <map>
#include <set>
#include <sstream>

#include "host/device/render/options/quality.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "host/device/runtime/program.hpp"
#include "io/scene/sensor_rig.hpp"
#include "optim/train/training.hpp"
#include "tests/optim/init/street_with_car.hpp"

namespace simuli {
namespace {

/// NAME=VALUE of each -D, but for what is a device's or a sensor's: shapes, digits, sizes of grids, levels at once.
std::set<std::string> defines_of(const std::string& options) {
  static const std::set<std::string> kElsewhere{
      "V", "NR", "LS", "RADIX_BITS", "GRID_X", "GRID_Y", "GRID_Z", "GRID_LEVELS", "SIMULI_REAL_DOUBLE"};
  std::set<std::string> out;
  std::istringstream words(options);
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos || word[0] == '-') continue;
    if (kElsewhere.count(word.substr(0, equals)) == 0) out.insert(word);
  }
  return out;
}

class GpuPrograms : public test::StreetWithCar {};

TEST_F(GpuPrograms, AreAllThatATrainingAndItsRenderingAskFor) {
  std::map<std::string, std::set<std::string>> listed;  // by file: what it is compiled with
  for (const test::GpuProgram& program : test::gpu_programs()) {
    std::set<std::string>& defines = listed["cl/" + program.path];
    defines.merge(defines_of(program.options.text()));
  }
  const Device device = Device::best();
  TrainingOptions options = training_options("",
                                             {"iterations=3",
                                              "image_scale=1",
                                              "init.voxel_m=0.15",
                                              "color_grids=pictures",
                                              "actors.track.learn=true"});
  Training training(device, log_, options);
  training.run();
  const SceneFile file = training.result();
  for (const Quality quality : {Quality::kDraft, Quality::kBalanced, Quality::kExact}) {
    SceneOnDevice scene(device, file.scene, options_of(quality));
    const SensorRig rig(file);
    for (const Sensor& sensor : {rig.find("front"), rig.find("top")})
      (void)scene.render(sensor, Shot::along(file.world_from_rig, sensor, 0.3), {.actors = true}).actors();
  }
  const std::vector<BuiltProgram> built = built_programs(device);
  EXPECT_GT(built.size(), 30U);
  for (const BuiltProgram& program : built) {
    // What CPUs go back by with vectors GPUs do with groups.
    const std::string path =
        program.path == "cl/kernels/render_bwd_lanes.cl" ? "cl/kernels/render_bwd_groups.cl" : program.path;
    ASSERT_EQ(listed.count(path), 1U) << path;
    for (const std::string& define : defines_of(program.options)) {
      EXPECT_EQ(listed[path].count(define), 1U)
          << path << " is asked for with " << define << ": tests/gpu_compile/gpu_programs.cpp lacks it";
    }
  }
}

}  // namespace
}  // namespace simuli
