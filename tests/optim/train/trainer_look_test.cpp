// Tests environment, bilateral grids and their regularisation in training.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numeric>

#include "io/picture/image.hpp"
#include "optim/base/frames.hpp"
#include "optim/init/initialize_sets.hpp"
#include "optim/train/trainer.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

class TrainerLook : public test::SmallStreet {
 protected:
  static TrainingOptions options(int iterations) {
    TrainingOptions o;
    o.train.iterations = iterations;
    o.frames.image_scale = 1.0;
    return o;
  }
  static Scene scene_with_environment() {
    InitOptions init;
    init.voxel_m = 0.2;
    init.sweep_depth = false;
    init.max_shell = 0;
    init.environment_width = 32;
    return initialize_scene(log_, kFullSize, init).scene;
  }
  /// Returns the street from a camera with changing exposure: every other picture at 0.6 of its brightness.
  static Log flickering_log() {
    Log log = log_;
    log.folder = folder_ / "flickering.log";
    if (std::filesystem::exists(log.folder)) return log;
    std::filesystem::create_directories(log.folder / "images");
    std::filesystem::copy(log_.folder / "sweeps", log.folder / "sweeps");
    for (std::size_t i = 0; i < log.images.size(); ++i) {
      Image image = read_image(log_.folder / log.images[i].file);
      if (i % 2 == 1) {
        for (float& value : image.data) value *= 0.6F;
      }
      write_image(log.folder / log.images[i].file, image);
    }
    return log;
  }
};

/// Returns the mean of the diagonals of a grid's matrices.
double mean_gain(const ColorGrids& grids, std::size_t frame) {
  const std::size_t count = grids.values_per_frame();
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % ColorGrids::kMatrix % 5 == 0) sum += grids.values[frame * count + i];
  }
  return sum / (static_cast<double>(count) / 4.0);
}

TEST_F(TrainerLook, SameSeedGivesTheSameBits) {
  TrainingOptions o = options(12);
  o.train.appearance.color_grids = ColorGridsOf::kPictures;
  o.train.image.dissimilarity = 0.2;
  const auto train = [&] {
    Trainer trainer(test::device(), log_, scene_with_environment(), o);
    EXPECT_EQ(trainer.run().rejected_gradients, 0U);
    return trainer.scene();
  };
  const Scene a = train(), b = train();
  EXPECT_TRUE((a.camera.params.array() == b.camera.params.array()).all());
  EXPECT_TRUE((a.lidar.params.array() == b.lidar.params.array()).all());
  EXPECT_EQ(a.environment.texels, b.environment.texels);
  EXPECT_EQ(a.color_grids.values, b.color_grids.values);
  EXPECT_NE(a.environment.texels, scene_with_environment().environment.texels);
  const auto& frames = a.color_grids.frames;
  ASSERT_EQ(frames.size(), 5U);  // one per training picture
  EXPECT_NE(a.color_grids.values, ColorGrids::identity(16, 16, 8, frames).values);
}

TEST_F(TrainerLook, WallsThatNoPictureShowsKeepTheirColours) {
  const Scene start = scene_with_environment();
  // By their index: particles move, and their order changes.
  const auto colours_of = [](const GaussianSet& set, const std::vector<Eigen::Index>& of) {
    std::map<std::array<float, 3>, int> times;
    for (const Eigen::Index i : of) ++times[{set.sh(0)(i, 0), set.sh(0)(i, 1), set.sh(0)(i, 2)}];
    return times;
  };
  const std::vector<Eigen::Index> walls = unseen_walls(start.camera);
  ASSERT_GT(walls.size(), 20U);
  ASSERT_LT(walls.size(), static_cast<std::size_t>(start.camera.size()) / 2);
  TrainingOptions o = options(20);
  o.train.densify.epochs = 0.0;
  Trainer trainer(test::device(), log_, start, o);
  static_cast<void>(trainer.run());
  const GaussianSet trained = trainer.scene().camera;
  std::vector<Eigen::Index> all(static_cast<std::size_t>(trained.size()));
  std::iota(all.begin(), all.end(), 0);
  const auto after = colours_of(trained, all);
  for (const auto& [colour, times] : colours_of(start.camera, walls)) {
    const auto found = after.find(colour);
    EXPECT_GE(found == after.end() ? 0 : found->second, times);
  }
}

TEST_F(TrainerLook, TheEnvironmentTakesOnTheSky) {
  Scene scene = scene_with_environment();
  const EnvironmentMap first_guess = scene.environment;
  for (float& texel : scene.environment.texels) texel = 0.0F;
  TrainingOptions o = options(80);
  o.train.appearance.environment_rate = 0.05;
  Trainer trainer(test::device(), log_, scene, o);
  const TrainReport report = trainer.run();
  // The camera points along +x: the middle of the texture, above the horizon.
  const EnvironmentMap& learned = trainer.scene().environment;
  const std::size_t ahead = 3 * static_cast<std::size_t>(5 * learned.width + learned.width / 2);
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(learned.texels[ahead + c], first_guess.texels[ahead + c], 0.15);
  EXPECT_GT(report.last.psnr_db, 15.0);
}

TEST_F(TrainerLook, TheEnvironmentKeepsTheGroundsColoursAndIsNoStandInForIt) {
  // Particles with high transmittance.
  Scene start = scene_with_environment();
  start.camera.opacity_logit().setConstant(-1.0F);
  const auto train = [&](bool has_lidars) {
    Log log = log_;
    if (!has_lidars) log.sweeps.clear();
    TrainingOptions o = options(60);
    o.train.depth.weight = o.train.off_trajectory.weight = 0.0;
    o.train.lidar_every = 1000;
    o.train.camera.log_scale /= 3.0;  // as slow as in a long training: otherwise particles grow over the holes
    Trainer trainer(test::device(), log, start, o);
    trainer.run();
    return trainer.scene();
  };
  const Scene with = train(true), without = train(false);
  const EnvironmentMap& learned = with.environment;
  const auto ground = static_cast<std::size_t>(3 * learned.width * 9);  // of 16 rows of 11 degrees
  const auto differs = [&](const Scene& scene, std::size_t from, std::size_t to) {
    std::size_t count = 0;
    for (std::size_t i = from; i < to; ++i) {
      count += scene.environment.texels[i] != start.environment.texels[i] ? 1U : 0U;
    }
    return count;
  };
  EXPECT_GT(differs(with, 0, ground), 100U);
  EXPECT_EQ(differs(with, ground, learned.texels.size()), 0U);
  EXPECT_GT(differs(without, ground, learned.texels.size()), 30U);
  // Opacity of the picture's lowest quarter, the road.
  const auto opacity = [&](const Scene& scene) {
    SceneOnDevice on_device(test::device(), scene);
    const ImageFrame& image = log_.images[0];
    const Camera& camera = log_.camera(image.camera).model;
    const Frame frame =
        on_device.render(Sensor(camera, log_.camera(image.camera).rig_from_camera), shot_of(log_, image));
    const std::vector<float>& through = frame.results().transmittance;
    const std::size_t from = through.size() / 4 * 3;
    double sum = 0.0;
    for (std::size_t i = from; i < through.size(); ++i) sum += 1.0 - static_cast<double>(through[i]);
    return sum / static_cast<double>(through.size() - from);
  };
  EXPECT_GT(opacity(with), opacity(without) + 0.1) << opacity(with) << " and " << opacity(without);
}

/// Adam's steps do not depend on the scale of the gradient: texels with a weight of a hundredth of a pixel
/// would compensate all errors in front of them.
TEST_F(TrainerLook, BarelyVisibleTexelsKeepTheirColours) {
  Scene start = scene_with_environment();
  const auto moves = [&](double least_share) {
    TrainingOptions o = options(8);
    o.train.appearance.least_share = least_share;
    Trainer trainer(test::device(), log_, start, o);
    EXPECT_EQ(trainer.run().rejected_gradients, 0U);
    std::vector<float> out = trainer.scene().environment.texels;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::abs(out[i] - start.environment.texels[i]);
    return out;
  };
  const std::vector<float> all = moves(0.0), shown = moves(1.0);
  std::vector<float> shares;  // remaining share of a texel's motion
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i] > 1e-3F) shares.push_back(shown[i] / all[i]);
  }
  ASSERT_GT(shares.size(), 100U);
  std::sort(shares.begin(), shares.end());
  EXPECT_LT(shares[shares.size() / 100], 0.2F);  // barely visible
  EXPECT_GT(shares[shares.size() / 2], 0.8F);  // clearly visible
}

/// Scene and PSNR of the last pictures after 120 iterations with fast grids.
struct Look {
  Scene scene;
  double psnr_db = 0.0;
};
Look trained_appearance(const Log& log, const Scene& start, TrainingOptions options) {
  options.train.appearance.grid_rate = 0.02;
  Trainer trainer(test::device(), log, start, options);
  const TrainReport report = trainer.run();
  return {trainer.scene(), report.last.psnr_db};
}

TEST_F(TrainerLook, CamerasHaveTintsOfTheirOwnWhereSeveralTrain) {
  Log log = flickering_log();
  const auto train = [&](ColorGridsOf grids) {
    TrainingOptions o = options(120);
    o.train.appearance.color_grids = grids;
    return trained_appearance(log, initial_scene(), o);
  };
  // One camera only has its training pictures to separate.
  EXPECT_EQ(train(ColorGridsOf::kAuto).scene.color_grids.frames.size(), 5U);
  log.cameras.push_back(log.cameras[0]);
  log.cameras[1].model.name = "dim";
  for (std::size_t i = 1; i < log.images.size(); i += 2) log.images[i].camera = "dim";
  const auto [plain, plain_psnr_db] = train(ColorGridsOf::kNone);
  const auto [tinted, tinted_psnr_db] = train(ColorGridsOf::kAuto);
  EXPECT_TRUE(plain.color_grids.empty());
  EXPECT_GT(tinted_psnr_db, plain_psnr_db + 1.0);
  const ColorGrids& tints = tinted.color_grids;
  ASSERT_EQ(tints.frames.size(), 2U);
  EXPECT_EQ(tints.values_per_frame(), 16U * 16U * 8U * 12U);
  const std::size_t dim = tints.frames[0].camera == "dim" ? 0 : 1;
  EXPECT_LT(mean_gain(tints, dim), mean_gain(tints, 1 - dim) - 0.05);
}

TEST_F(TrainerLook, GridsTakeOnWhatDiffersFromPictureToPicture) {
  const Log log = flickering_log();
  const auto train = [&](ColorGridsOf grids) {
    TrainingOptions o = options(120);
    o.train.appearance.color_grids = grids;
    return trained_appearance(log, initial_scene(), o);
  };
  const auto [plain, plain_psnr_db] = train(ColorGridsOf::kNone);
  const auto [graded, graded_psnr_db] = train(ColorGridsOf::kPictures);
  EXPECT_TRUE(plain.color_grids.empty());
  EXPECT_GT(graded_psnr_db, plain_psnr_db + 1.0);
  // The grids of the dark pictures are darker than their neighbours'.
  const auto gain = [&grids = graded.color_grids](std::size_t frame) { return mean_gain(grids, frame); };
  EXPECT_LT(gain(1), gain(0) - 0.05);
  EXPECT_LT(gain(3), gain(2) - 0.05);
  // The held-out picture (a bright one, number 4) uses its neighbours' grids: its error is mostly a tint.
  const EvalOptions once{.image_scale = 1.0, .timed_renders = 1};
  const EvalReport report = test::compare(log, graded, once);
  EXPECT_GT(report.psnr_corrected_db, report.psnr_db + 1.0);
  EXPECT_NE(test::compare(log, plain, once).psnr_db, report.psnr_db);
}

TEST_F(TrainerLook, GridsThatTakeFewStepsTakeLongOnes) {
  const Log log = flickering_log();
  TrainingOptions o = options(20);  // four per grid
  o.train.appearance.color_grids = ColorGridsOf::kPictures;
  Trainer trainer(test::device(), log, initial_scene(), o);
  (void)trainer.run();
  const ColorGrids grids = trainer.scene().color_grids;
  const std::vector<float> same = ColorGrids::identity(16, 16, 8, grids.frames).values;
  double farthest = 0.0;
  for (std::size_t i = 0; i < same.size(); ++i) {
    farthest = std::max(farthest, static_cast<double>(std::abs(grids.values[i] - same[i])));
  }
  EXPECT_GT(farthest, 3.0 * 4.0 * o.train.appearance.grid_rate);  // Adam moves at most its rate per step
}

}  // namespace
}  // namespace simuli
