// Tests several frames per step: equal bits for any number of ranks.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>
#include <string>

#include "optim/train/memory.hpp"
#include "optim/train/ranks/ranks.hpp"
#include "optim/train/trainer.hpp"
#include "tests/optim/small_street.hpp"

namespace simuli {
namespace {

class ShardsTest : public test::SmallStreet {
 protected:
  static constexpr int kIterations = 12;
  /// Enables all gradients and all changes of the set.
  static TrainingOptions options(int shards) {
    TrainingOptions o;
    o.train.iterations = kIterations;
    o.train.shards.count = shards;
    o.frames.image_scale = 1.0;
    o.train.lidar_every = 2;
    o.train.densify.epochs = 0.8;
    o.train.densify.lidar = true;
    o.train.densify.noise = 1e4;
    o.train.anchor.weight = 0.01;
    o.train.prune = {.weight = 0.05, .first = 0, .times = 2, .last_share = 0.75};
    o.train.actor_poses = {.learn = true, .shift_m = 1e-2};
    o.train.appearance.color_grids = ColorGridsOf::kPictures;
    o.train.ray_drop.apart = 2;
    return o;
  }
  /// Returns a scene with an environment and a static actor that owns every third particle.
  static Scene start() {
    Scene scene = initial_scene();
    scene.environment = {32, 16, std::vector<float>(std::size_t{3} * 32 * 16, 0.5F)};
    Actor actor{.name = "car", .kind = "car", .size_m = Eigen::Vector3d::Constant(400.0), .track = {}};
    for (const double time_s : {0.0, 0.2, 0.4, 0.6}) {
      KeyPose key{.time_s = time_s, .world_from_actor = {}};
      key.world_from_actor.translation = scene.origin;
      actor.track.push_back(key);
    }
    scene.actors.push_back(actor);
    for (GaussianSet* const set : {&scene.camera, &scene.lidar}) {
      set->actor.assign(static_cast<std::size_t>(set->size()), 0);
      for (std::size_t i = 0; i < set->actor.size(); i += 3) set->actor[i] = 1;
    }
    return scene;
  }
  static std::string bytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// One after the other: not all drivers support concurrent opening.
  static std::vector<Device> opened(std::size_t count) {
    std::vector<Device> devices;
    for (std::size_t i = 0; i < count; ++i) devices.push_back(Device::best());
    return devices;
  }
  /// Returns the complete state of a training with `ranks` threads, each with its own device object.
  static std::string state(const TrainingOptions& o, std::size_t ranks, const std::string& resumed = "") {
    const std::filesystem::path file = folder_ / "shards.state";
    const std::vector<Device> devices = opened(ranks);
    run_rank_threads(ranks, [&](Ranks& own) {
      Trainer trainer(devices[own.rank()], log_, start(), o, own);
      if (!resumed.empty()) trainer.resume(folder_ / resumed, "");
      while (trainer.status().iteration < kIterations) {
        trainer.step();
        if (trainer.status().iteration == kIterations / 2 && own.is_first()) {
          trainer.save(folder_ / fmt::format("half_{}.state", ranks), "");
        }
      }
      trainer.need_one_state("");
      if (own.is_first()) trainer.save(file, "");
    });
    return bytes(file);
  }
};

TEST_F(ShardsTest, AnyNumberOfRanksGivesTheSameBits) {
  const TrainingOptions o = options(4);
  const std::string alone = state(o, 1);
  EXPECT_GT(alone.size(), 1'000'000U);
  // With three ranks, two have no shard in the second round.
  for (const std::size_t ranks : {2U, 3U, 4U}) EXPECT_TRUE(state(o, ranks) == alone) << ranks;
  EXPECT_TRUE(state(o, 1, "half_3.state") == alone) << "goes on alone";
  EXPECT_TRUE(state(o, 2, "half_4.state") == alone) << "goes on with two";
  TrainingOptions other = o;
  other.frames.seed = 2;
  EXPECT_FALSE(state(other, 1) == alone);
}

TEST_F(ShardsTest, AStepTakesTheMeanOfItsFrames) {
  // One frame, so that all shards have equal data: the result of a step with one shard.
  Log log = log_;
  log.images.resize(1);
  log.sweeps.resize(1);
  TrainingOptions o;
  o.train.iterations = 3;
  o.train.lidar.log_scale /= 3.0;  // slow, as in a long training: thirds have rounding errors
  o.train.shards.rate_power = 0.0;
  o.train.densify.epochs = 0.0;
  o.train.ray_drop.rate = 0.0;                           // several steps of the function per sweep
  o.train.appearance.color_grids = ColorGridsOf::kNone;  // each picture's grid moves once per shard
  o.train.off_trajectory.weight = 0.0;                   // each shard uses another view
  o.train.depth.weight = 0.0;                            // each shard uses another part of the sweep
  o.frames.held_out_every = 0;
  const auto scene = [&](int shards) {
    o.train.shards.count = shards;
    Trainer trainer(Device::best(), log, initial_scene(), o);
    (void)trainer.run();
    return trainer.scene();
  };
  const Scene one = scene(1), four = scene(4), three = scene(3);
  // Quarters add up without rounding, thirds do not.
  EXPECT_TRUE((one.camera.params.array() == four.camera.params.array()).all());
  EXPECT_TRUE((one.lidar.params.array() == four.lidar.params.array()).all());
  EXPECT_FALSE((one.camera.params.array() == three.camera.params.array()).all());
  EXPECT_LT((one.lidar.params - three.lidar.params).cwiseAbs().maxCoeff(), 2e-2F);
}

TEST_F(ShardsTest, FramesAreSeenInTheOrderOfOneShard) {
  // As many frames with four per step as with one: both have the latest loss of each picture.
  TrainingOptions o = options(4);
  Trainer trainer(Device::best(), log_, start(), o);
  trainer.step();
  EXPECT_TRUE(std::isfinite(trainer.status().psnr_db));
  o.train.length.automatic = true;
  o.train.length.first_epochs = 100;
  Trainer lasting(Device::best(), log_, start(), o);
  EXPECT_EQ(lasting.status().planned, 200);  // five training pictures: an epoch takes two steps
}

TEST_F(ShardsTest, ADifferentStateIsNamed) {
  try {
    const std::vector<Device> devices = opened(2);
    run_rank_threads(2, [&](Ranks& own) {
      Scene scene = start();
      if (own.rank() == 1) scene.camera.params(0, 0) += 1e-3F;
      Trainer trainer(devices[own.rank()], log_, std::move(scene), options(2), own);
      trainer.need_one_state("");
    });
    ADD_FAILURE() << "taken for the same";
  } catch (const RanksDiffer& differ) {
    EXPECT_EQ(std::string(differ.what()).rfind("rank 1: camera/parameters: found ", 0), 0U) << differ.what();
  }
}

TEST_F(ShardsTest, MemoryOfShardsIsTold) {
  const TrainingOptions o = options(2);
  const Device device = Device::best();
  const MemoryNeed need = training_memory(device, log_, start(), o);
  Trainer trainer(device, log_, start(), o);
  (void)trainer.run();
  for (const auto& [name, use] : device.memory_by_name()) {
    if (use.now == 0) continue;
    const auto reported = need.by_buffer.find(name);
    ASSERT_NE(reported, need.by_buffer.end()) << name << ": " << use.now << " bytes that nobody told";
    EXPECT_LE(use.now, 2 * reported->second) << name;
  }
}

TEST_F(ShardsTest, MendedPicturesAreRefused) {
  TrainingOptions o = options(2);
  o.fixer_command = "true";
  EXPECT_THROW((void)checked(o), Error);
  o.train.shards.count = 1;
  EXPECT_NO_THROW((void)checked(o));
}

}  // namespace
}  // namespace simuli
