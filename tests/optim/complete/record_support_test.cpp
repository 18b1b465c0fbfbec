// Tests the support records of trainings and their error estimates.
#include "optim/complete/record_support.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <set>

#include "optim/base/frames.hpp"
#include "optim/complete/support_reliability.hpp"
#include "optim/train/training.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

class RecordSupport : public test::SmallStreet {
 protected:
  [[nodiscard]] SceneFile trained() const {
    TrainingOptions o;
    o.frames.image_scale = 1.0;
    o.init.voxel_m = 0.3;
    o.init.sweep_depth = false;
    o.train.iterations = 40;
    o.train.lidar_every = 2;
    Training training(test::device(), log_, o);
    training.run();
    return training.result();
  }
};

TEST_F(RecordSupport, IsOfTheTrainingFramesAlone) {
  const SceneFile scene = trained();
  ASSERT_NE(scene.support, nullptr);
  const SupportRecord& record = *scene.support;
  const HeldOutRule rule(log_, FrameSelection{});
  const std::size_t images = rule.training(log_.images).size(), sweeps = rule.training(log_.sweeps).size();
  EXPECT_LT(images, log_.images.size());
  EXPECT_EQ(record.views.size(), images + sweeps);
  EXPECT_EQ(record.sensors.size(), log_.cameras.size() + log_.lidars.size());
  for (const SupportView& view : record.views) {
    const Pose& at = view.world_from_view;
    EXPECT_LT((at.translation - log_.world_from_rig.at(view.time_s).translation).norm(), 4.0);
  }
  const auto seen = std::count_if(
      record.cells.begin(), record.cells.end(), [](const SupportCell& c) { return c.farthest_m > 0.0F; });
  EXPECT_GT(seen, static_cast<std::ptrdiff_t>(record.cells.size() / 2));
}

TEST_F(RecordSupport, IsHighOnThePathAndForetellsErrors) {
  const SceneFile file = trained();
  const Device& device = test::device();
  SceneOnDevice scene(device, file.scene);
  SupportOnDevice support(device, file.support);
  const ImageFrame& frame = log_.images[log_.images.size() / 2];
  const LogCamera& camera = log_.camera(frame.camera);
  const auto mean = [&](const Pose& moved) {
    const Shot shot = Shot::at(Sensor(camera.model, camera.rig_from_camera),
                               log_.world_from_rig.at(frame.time_start_s) * moved,
                               frame.time_start_s);
    const std::vector<float> known = support.of(scene.render(Sensor(camera.model), shot), scene.scene());
    double sum = 0.0;
    for (const float value : known) sum += static_cast<double>(value) / static_cast<double>(known.size());
    return sum;
  };
  const double here = mean({});
  const Pose aside{Eigen::Quaterniond::Identity(), {0.0, 4.0, 0.0}};
  const Pose behind{Eigen::Quaterniond(Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitZ())), {0.0, 0.0, 0.0}};
  EXPECT_GT(here, mean(aside));
  EXPECT_LT(mean(behind), 0.3 * here);

  SupportSamples pixels, rays;
  pixels.add_picture(scene, support, log_, frame, camera.model);
  rays.add_sweep(scene, support, log_, log_.sweeps.front());
  for (const auto& [samples, limit] :
       {std::pair{&pixels, kSupportColour}, std::pair{&rays, kSupportRange_m}}) {
    const SupportReliability found = reliability(*samples, limit);
    EXPECT_EQ(found.count, samples->support.size());
    EXPECT_GT(found.rank_correlation, 0.3);
    std::size_t in_bins = 0;
    for (const SupportReliability::Bin& bin : found.bins) in_bins += bin.count;
    EXPECT_EQ(in_bins, found.count);
  }
}

TEST_F(RecordSupport, IsNotBlamedForATintThatNothingTells) {
  const SceneFile file = trained();
  SceneOnDevice scene(test::device(), file.scene);
  SupportOnDevice support(test::device(), file.support);
  ImageFrame frame = log_.images[2];
  const Camera& camera = log_.camera(frame.camera).model;
  Image darker = load_image(log_, frame, camera);
  for (std::size_t i = 0; i < darker.data.size(); ++i) darker.data[i] *= i % 3 == 0 ? 0.6F : 0.5F;
  frame.file = "darker.png";
  write_image(log_.folder / frame.file, darker);
  const auto right = [&](SupportOnDevice& by, Tint tint) {
    SupportSamples pixels;
    pixels.add_picture(scene, by, log_, frame, camera, 1, tint);
    return reliability(pixels, kSupportColour).right;
  };
  const double blamed = right(support, Tint::kKnown);
  EXPECT_LT(blamed, 0.3);
  EXPECT_GT(right(support, Tint::kUnknown), 0.7);
  // Without supported pixels the tint is unknown.
  const auto of_others = std::make_shared<SupportRecord>(*file.support);
  for (SupportView& view : of_others->views) view.world_from_view.translation.x() += 1000.0;
  SupportOnDevice none(test::device(), of_others);
  EXPECT_EQ(right(none, Tint::kUnknown), blamed);
}

TEST(SupportReliability, RanksAndBinsAreThoseOfTheirDefinition) {
  SupportSamples samples;
  for (int i = 0; i < 100; ++i) {
    samples.support.push_back((static_cast<float>(i) + 0.5F) / 100.0F);
    samples.error.push_back(static_cast<float>(100 - i));
  }
  SupportReliability found = reliability(samples, 50.5);
  EXPECT_NEAR(found.rank_correlation, 1.0, 1e-12);
  EXPECT_NEAR(found.right, 0.5, 1e-12);
  for (const SupportReliability::Bin& bin : found.bins) EXPECT_EQ(bin.count, 10U);
  EXPECT_NEAR(found.bins[0].support, 0.05, 1e-6);
  EXPECT_EQ(found.bins[9].right, 1.0);
  EXPECT_EQ(found.bins[0].right, 0.0);
  std::reverse(samples.error.begin(), samples.error.end());
  EXPECT_NEAR(reliability(samples, 50.5).rank_correlation, -1.0, 1e-12);
  samples.support.assign(100, 0.5F);
  EXPECT_EQ(reliability(samples, 50.5).rank_correlation, 0.0);
  EXPECT_EQ(reliability({}, 1.0).count, 0U);
}

}  // namespace
}  // namespace simuli
