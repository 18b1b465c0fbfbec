// Tests a walking person, trained with a deformation and as a rigid actor.
#include <filesystem>
#include <gtest/gtest.h>
#include <iostream>
#include <stdlib.h>

#include "host/core/scene/edit.hpp"
#include "optim/train/trainer.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

class Walker : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (std::filesystem::temp_directory_path() / "simuli_walker_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    StreetOptions options;
    options.output = folder_ / "street.log";
    options.frames = 20;
    options.speed_m_per_s = 0.5;
    options.image_width = 160;
    options.image_height = 120;
    options.lidar_columns = 600;
    options.moving_car = false;
    options.walking_person = true;
    options.walker.start_m = {7.0, -2.4};
    log_ = synth_street(options);
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }

  static TrainingOptions options(bool shapes, int iterations) {
    TrainingOptions o;
    o.train.iterations = iterations;
    o.train.lidar_every = 1;
    o.train.learn_shapes = shapes;
    o.frames.image_scale = 1.0;
    o.frames.held_out_every = 5;
    return o;
  }
  static Scene initial_scene() {
    InitOptions init;
    init.voxel_m = 0.2;
    init.sweep_depth = false;
    return initialize_scene(log_, {.image_scale = 1.0, .held_out_every = 5}, init).scene;
  }
  static double largest_offset_m(const Scene& scene) {
    double largest = 0.0;
    for (const double o : scene.actors.at(0).deformation.offsets_m) largest = std::max(largest, std::abs(o));
    return largest;
  }

  inline static std::filesystem::path folder_;
  inline static Log log_;
};

TEST_F(Walker, IsShownBetterWithAShapeThatChanges) {
  EvalReport reports[2];
  Scene scenes[2];
  for (const bool shapes : {false, true}) {
    Trainer trainer(test::device(), log_, initial_scene(), options(shapes, 120));
    (void)trainer.run();
    scenes[shapes ? 1 : 0] = trainer.scene();
    reports[shapes ? 1 : 0] = test::compare(log_, trainer.scene(), {.held_out_every = 5});
  }
  const EvalReport& rigid = reports[0];
  const EvalReport& shaped = reports[1];
  for (const EvalReport* const r : {&rigid, &shaped}) {
    std::cout << "in the box " << r->actor_psnr_db << " dB, met " << r->actor_share_met << ", "
              << 100.0 * r->actor_distance_median_m << " cm; all " << r->psnr_db << " dB, "
              << 100.0 * r->lidar.distance_median_m << " cm\n";
  }
  ASSERT_EQ(scenes[0].actors.size(), 1U);
  EXPECT_TRUE(scenes[0].actors[0].deformation.empty());
  EXPECT_GT(largest_offset_m(scenes[1]), 0.05);
  EXPECT_GT(shaped.actor_psnr_db, rigid.actor_psnr_db + 0.1);
  EXPECT_GT(shaped.actor_share_met, rigid.actor_share_met);
  EXPECT_GT(shaped.psnr_db, rigid.psnr_db - 0.05);
  EXPECT_LT(shaped.lidar.distance_median_m, rigid.lidar.distance_median_m + 0.001);
  // Edits keep the deformation: a copy beside the original, and neither of them.
  Scene edited = scenes[1];
  duplicate_actor(edited, "person", "twin");
  EXPECT_EQ(edited.actors[1].deformation.offsets_m, edited.actors[0].deformation.offsets_m);
  remove_actor(edited, "person");
  remove_actor(edited, "twin");
  EXPECT_TRUE(edited.actors.empty());
}

TEST_F(Walker, ResumedGivesTheSameBits) {
  const TrainingOptions o = options(true, 12);
  Trainer whole(test::device(), log_, initial_scene(), o);
  for (int i = 0; i < 12; ++i) {
    whole.step();
    if (i == 5) whole.save(folder_ / "checkpoint", "settings=1\n");
  }
  Trainer resumed(test::device(), log_, initial_scene(), o);
  resumed.resume(folder_ / "checkpoint", "settings=1\n");
  (void)resumed.run();
  const Scene expected = whole.scene(), found = resumed.scene();
  EXPECT_GT(largest_offset_m(expected), 0.0);
  EXPECT_EQ(found.actors.at(0).deformation.offsets_m, expected.actors.at(0).deformation.offsets_m);
  EXPECT_EQ(found.camera.params, expected.camera.params);
  EXPECT_EQ(found.lidar.params, expected.lidar.params);
}

TEST_F(Walker, LearnsFromSeveralFramesAStep) {
  TrainingOptions o = options(true, 6);
  o.train.shards.count = 2;
  Trainer trainer(test::device(), log_, initial_scene(), o);
  (void)trainer.run();
  EXPECT_GT(largest_offset_m(trainer.scene()), 0.0);
}

}  // namespace
}  // namespace simuli
