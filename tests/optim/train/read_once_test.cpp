// Tests how often a training reads its frames.
#include <gtest/gtest.h>

#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"
#include "optim/init/initialize.hpp"
#include "optim/data/refined_path.hpp"
#include "optim/train/memory.hpp"
#include "optim/train/trainer.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

class ReadOnceTest : public test::SmallStreet {
 protected:
  /// Runs initialisation and some steps with a small frame budget on the device.
  static Scene trained(const Log& log) {
    TrainingOptions o;
    o.frames.image_scale = 1.0;
    o.frames.held_out_every = 0;
    o.train.iterations = 24;
    o.train.cache_bytes = 1;
    SceneInit init = initialize_scene(log, o.frames, o.init);
    Trainer trainer(test::device(), log, std::move(init.scene), o);
    (void)trainer.run();
    return trainer.scene();
  }
};

TEST_F(ReadOnceTest, EachFrameIsReadOnceAndNothingElseChanges) {
  Log log = log_;
  log.files = std::make_shared<FrameFiles>(frame_bytes(log, kFullSize));
  const Scene kept = trained(log), read = trained(log_);
  EXPECT_EQ(log.files->reads(), log.images.size() + log.sweeps.size());
  EXPECT_EQ(log.files->kept_bytes(), frame_bytes(log, kFullSize));
  EXPECT_TRUE((kept.camera.params.array() == read.camera.params.array()).all());
  EXPECT_TRUE((kept.lidar.params.array() == read.lidar.params.array()).all());
  // Without a budget frames are read ahead, and the result is equal.
  log.files = std::make_shared<FrameFiles>(0);
  const Scene ahead = trained(log);
  EXPECT_GT(log.files->reads(), log.images.size() + log.sweeps.size());
  EXPECT_TRUE((ahead.camera.params.array() == read.camera.params.array()).all());
  EXPECT_TRUE((ahead.lidar.params.array() == read.lidar.params.array()).all());
}

TEST_F(ReadOnceTest, TheBudgetIsAShareOfWhatMayBeTaken) {
  TrainingOptions o;
  o.train.host_cache_bytes = 1'000'000;
  EXPECT_EQ(frame_budget(o), 1'000'000U);
  o.chunks.host_memory_bytes = 4'000'000;
  EXPECT_EQ(frame_budget(o), 500'000U);
  o.train.host_cache_bytes = 0;
  EXPECT_EQ(frame_budget(o), 0U);
}

}  // namespace
}  // namespace simuli
