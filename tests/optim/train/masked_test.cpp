// Tests that masked pixels have no effect on training and scores.
#include <gtest/gtest.h>

#include "host/core/record/support_record.hpp"
#include "io/log/camera_mask.hpp"
#include "optim/train/training.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace {

class MaskedTest : public test::SmallStreet {
 protected:
  /// Returns the street with noise in the lower rows of all pictures, in place of the ego vehicle.
  static Log with_noise(const std::string& name, std::uint64_t seed, bool masked) {
    Log log = log_;
    std::map<std::string, std::filesystem::path> files;
    if (masked) {
      const Camera& camera = log.cameras.front().model;
      Image hood(camera.width, camera.height, 3);
      for_hood(hood, [](float& value) { value = 1.0F; });
      write_image(folder_ / (name + ".png"), hood);
      log.masks = {{camera.name, "masks/hood.png"}};
      files["masks/hood.png"] = folder_ / (name + ".png");
    }
    copy_log(log, folder_ / name, files);
    test::Random random(seed);
    for (const ImageFrame& frame : log.images) {
      Image picture = read_image(folder_ / name / frame.file);
      for_hood(picture, [&](float& value) { value = static_cast<float>(random.uniform(0.0, 1.0)); });
      write_image(folder_ / name / frame.file, picture);
    }
    return read_log(folder_ / name);
  }

  static TrainingOptions options(double image_scale) {
    TrainingOptions o;
    o.frames.image_scale = image_scale;
    o.init.voxel_m = 0.3;
    o.train.iterations = 30;
    o.train.lidar_every = 4;
    o.train.densify.epochs = 2.0;
    o.train.appearance.color_grids = ColorGridsOf::kPictures;
    return o;
  }

  static SceneFile trained(const Log& log, const TrainingOptions& o) {
    Training training(test::device(), log, o);
    training.run();
    return std::move(training).result();
  }

 private:
  template <class Change>
  static void for_hood(Image& picture, const Change& change) {
    for (int y = 25; y < picture.height; ++y) {
      const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width);
      for (std::size_t i = 3 * row; i < 3 * (row + static_cast<std::size_t>(picture.width)); ++i)
        change(picture.data[i]);
    }
  }
};

TEST_F(MaskedTest, WhatIsHiddenChangesNoBit) {
  const Log one = with_noise("one", 1, true), other = with_noise("other", 2, true);
  double masked_db = 0.0;
  for (const double image_scale : {1.0, 0.5}) {
    SCOPED_TRACE(image_scale);
    const SceneFile a = trained(one, options(image_scale)), b = trained(other, options(image_scale));
    EXPECT_GT(a.scene.camera.size(), 100);
    EXPECT_EQ(a.scene.camera.params, b.scene.camera.params);
    EXPECT_EQ(a.scene.lidar.params, b.scene.lidar.params);
    EXPECT_EQ(a.scene.environment.texels, b.scene.environment.texels);
    ASSERT_EQ(a.support->views.size(), b.support->views.size());
    const EvalReport scores_a = Evaluation(test::device(), a, one, {}).run();
    const EvalReport scores_b = Evaluation(test::device(), b, other, {}).run();
    EXPECT_EQ(scores_a.psnr_db, scores_b.psnr_db);
    EXPECT_GT(scores_a.psnr_db, 15.0);
    if (image_scale < 1.0) continue;
    masked_db = scores_a.psnr_db;
    EXPECT_EQ(scores_a.ssim, scores_b.ssim);
    EXPECT_GT(scores_a.ssim, 0.2);
  }
  // Without the mask the noise is trained and scored.
  const Log open = with_noise("open", 1, false);
  const SceneFile smeared = trained(open, options(1.0));
  EXPECT_LT(Evaluation(test::device(), smeared, open, {}).run().psnr_db, masked_db - 1.0);
}

}  // namespace
}  // namespace simuli
