// Tests off-trajectory views, with ground truth of the street.
#include <gtest/gtest.h>

#include "optim/train/trainer.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

class OffTrajectoryTest : public test::SmallStreet {
 protected:
  static TrainingOptions options(double weight) {
    TrainingOptions o;
    o.train.iterations = 150;
    o.frames.image_scale = 1.0;
    o.train.off_trajectory.weight = weight;
    return o;
  }
  static Scene train(double weight) {
    Trainer trainer(test::device(), log_, initial_scene(), options(weight));
    static_cast<void>(trainer.run());
    return trainer.scene();
  }
  /// Returns the street one metre to the left of the trajectory.
  static Log beside() {
    StreetOptions options;
    options.output = folder_ / "beside.log";
    options.frames = 6;
    options.image_width = 64;
    options.image_height = 36;
    options.lidar_columns = 90;
    options.moving_car = false;
    options.lane_shift_m = 1.0;
    return synth_street(options);
  }
};

TEST_F(OffTrajectoryTest, PicturesTellWhatIsSeenFromThere) {
  const Log there = beside();
  const EvalOptions all{.image_scale = 1.0, .held_out_every = 0};
  const Scene without = train(0.0), with = train(0.5);
  const double before_db = test::compare(there, without, all).psnr_db;
  EXPECT_GT(test::compare(there, with, all).psnr_db, before_db + 0.1) << before_db;
  const double path_db = test::compare(log_, without, all).psnr_db;
  EXPECT_GT(test::compare(log_, with, all).psnr_db, path_db - 0.2) << path_db;
}

}  // namespace
}  // namespace simuli
