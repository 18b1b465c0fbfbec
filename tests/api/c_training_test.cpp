// Training and evaluation in C do what they do in C++.
#include <cmath>
#include <fstream>
#include <iterator>
#include <simuli/simuli.h>

#include "tests/api/small_scene.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class CTraining : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    log_ = write_small_log(folder_ / "small.log");
    ASSERT_EQ(simuli_device_open(nullptr, &device_), SIMULI_OK) << simuli_error();
  }
  void TearDown() override {
    simuli_device_close(device_);
    ScratchTest::TearDown();
  }
  /// A log of pictures and sweeps of the small scene, as it renders them itself.
  static std::string write_small_log(const fs::path& folder) {
    SceneFile file = small_scene();
    const SensorRig rig(file);
    Log log;
    log.folder = folder;
    log.name = "small";
    log.cameras = file.cameras;
    log.lidars = file.lidars;
    log.world_from_rig = file.world_from_rig;
    fs::create_directories(folder / "images");
    fs::create_directories(folder / "sweeps");
    SceneOnDevice scene(Device::best(), std::move(file.scene));
    for (int i = 0; i < 6; ++i) {
      const double time_s = 0.15 * i;
      const Sensor camera = rig.find("front").resized(48, 36), lidar = rig.find("velodyne_vlp16");
      log.cameras[0].model = camera.camera();
      const std::string image = "images/" + std::to_string(i) + ".png";
      write_image(folder / image,
                  scene.render(camera, Shot::along(log.world_from_rig, camera, time_s)).image());
      log.images.push_back({"front", image, time_s, time_s});
      LidarFrame seen = scene.render(lidar, Shot::along(log.world_from_rig, lidar, time_s)).lidar();
      const std::string sweep = "sweeps/" + std::to_string(i) + ".exr";
      write_sweep(folder / sweep, {std::move(seen.rays), std::move(seen.range), std::move(seen.intensity)});
      log.sweeps.push_back({"velodyne_vlp16", sweep, time_s, time_s + 0.1});
    }
    write_log(log);
    return folder.string();
  }

  std::string log_;
  simuli_device* device_ = nullptr;
};

TEST_F(CTraining, GivesTheSameSceneAndTheSameNumbers) {
  const char* const settings[] = {"iterations=4", "image_scale=1"};
  const simuli_options options{"draft", settings, 2};
  int calls = 0;
  const auto count = [](int, double, void* user) { return ++*static_cast<int*>(user), 0; };
  simuli_training trained{};
  const std::string scene = (folder_ / "c.scene").string();
  ASSERT_EQ(simuli_train(device_, log_.c_str(), scene.c_str(), &options, count, &calls, &trained), SIMULI_OK)
      << simuli_error();
  EXPECT_EQ(calls, 4);
  EXPECT_EQ(trained.iterations, 4);
  EXPECT_GT(trained.lidar_particles, 0U);

  TrainingOptions same;
  same.train.iterations = 4;
  same.frames.image_scale = 1.0;
  same.train.render = training_options_of(Quality::kDraft);
  const Device device = Device::best();
  Training training(device, read_log(log_), same);
  training.run();
  (void)write_trained_scene(
      folder_ / "cpp.scene", device, training.result(), read_log(log_), same.train.render);
  for (const char* file : {"camera.ply", "lidar.ply", "scene.json"}) {
    const std::string of_c = bytes_of(fs::path(scene) / file);
    EXPECT_FALSE(of_c.empty()) << file;
    EXPECT_TRUE(of_c == bytes_of(folder_ / "cpp.scene" / file)) << file;
  }

  simuli_evaluation found{};
  ASSERT_EQ(simuli_evaluate(device_, scene.c_str(), log_.c_str(), nullptr, &found), SIMULI_OK)
      << simuli_error();
  const EvalReport report = Evaluation(device, training.result(), read_log(log_)).run();
  EXPECT_EQ(found.psnr_db, report.psnr_db);
  EXPECT_TRUE(std::isfinite(found.psnr_db));
  EXPECT_EQ(found.raydrop_accuracy, report.lidar.raydrop_accuracy);
  EXPECT_EQ(found.raydrop_trivial, report.lidar.raydrop_trivial);
  EXPECT_EQ(found.drop_recall, report.lidar.drop_recall);
  EXPECT_EQ(found.drop_precision, report.lidar.drop_precision);
  EXPECT_EQ(found.images, 1U);
  EXPECT_EQ(found.is_held_out, 1);

  // How well a frame is known.
  simuli_scene* opened = nullptr;
  ASSERT_EQ(simuli_scene_open(device_, scene.c_str(), &opened), SIMULI_OK) << simuli_error();
  const SceneFile file = read_scene(scene);
  SceneOnDevice on_device(device, file.scene);
  SupportOnDevice support(device, file.support);
  const SensorRig rig(file);
  for (const char* name : {"front", "velodyne_vlp16"}) {
    simuli_shot shot{};
    simuli_frame* frame = nullptr;
    const Sensor sensor = rig.find(name);
    ASSERT_EQ(simuli_scene_shot(opened, name, 0.2, 0.2 + sensor.duration_s(), &shot), SIMULI_OK)
        << simuli_error();
    ASSERT_EQ(simuli_render(opened, name, &shot, nullptr, &frame), SIMULI_OK) << simuli_error();
    std::vector<float> values(sensor.ray_count());
    EXPECT_EQ(simuli_frame_support(opened, frame, values.data(), values.size() - 1), SIMULI_USAGE);
    ASSERT_EQ(simuli_frame_support(opened, frame, values.data(), values.size()), SIMULI_OK) << simuli_error();
    const Frame rendered = on_device.render(sensor, Shot::along(file.world_from_rig, sensor, 0.2));
    EXPECT_EQ(values, support.of(rendered, file.scene)) << name;
    EXPECT_GT(*std::max_element(values.begin(), values.end()), 0.0F) << name;
    simuli_frame_close(frame);
  }
  simuli_scene_close(opened);

  // The settings of a comparison choose its frames: the last quarter of the path, part of which was trained
  // on.
  const char* const end[] = {"held_out_last=0.25"};
  const simuli_options of_end{nullptr, end, 1};
  ASSERT_EQ(simuli_evaluate(device_, scene.c_str(), log_.c_str(), &of_end, &found), SIMULI_OK)
      << simuli_error();
  EXPECT_EQ(found.is_held_out, 0);
  EXPECT_GT(found.images, 0U);
}

TEST_F(CTraining, EndsWhenItsObserverSaysSoAndNamesWhatIsWrong) {
  const auto stop = [](int iteration, double, void*) { return iteration == 2 ? 1 : 0; };
  EXPECT_EQ(simuli_train(device_, log_.c_str(), log_.c_str(), nullptr, stop, nullptr, nullptr), SIMULI_INPUT);
  EXPECT_NE(std::string(simuli_error()).find("not exist yet"), std::string::npos) << simuli_error();
  const std::string scene = (folder_ / "c.scene").string();
  EXPECT_EQ(simuli_train(device_, log_.c_str(), scene.c_str(), nullptr, stop, nullptr, nullptr),
            SIMULI_USAGE);
  EXPECT_EQ(std::string(simuli_error()), "training: ended by its observer");
  EXPECT_FALSE(fs::exists(scene));
  const char* const wrong[] = {"iterations=-1"};
  const simuli_options options{nullptr, wrong, 1};
  EXPECT_EQ(simuli_train(device_, log_.c_str(), scene.c_str(), &options, nullptr, nullptr, nullptr),
            SIMULI_USAGE);
  EXPECT_NE(std::string(simuli_error()).find("iterations: found"), std::string::npos) << simuli_error();
}

}  // namespace
}  // namespace simuli
