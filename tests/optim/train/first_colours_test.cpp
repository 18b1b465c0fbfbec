// Colours in closed form at the start of a training.
#include "optim/train/first_colours.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

#include "host/device/render/scene/scene_on_device.hpp"
#include "optim/base/frames.hpp"
#include "tests/optim/small_street.hpp"

namespace simuli {
namespace {

class FirstColours : public test::SmallStreet {
 protected:
  /// The scene as a training of so many iterations takes it, and with the colours that it solves. Without an
  /// environment, whose ground trainings start without.
  struct Start {
    Scene before, solved;
  };
  static Start start(int iterations) {
    Scene scene = initial_scene();
    scene.environment = {};
    TrainingOptions options;
    options.train.iterations = iterations;
    options.frames = kFullSize;
    TrainerState state(test::device(), log_, std::move(scene), options);
    Start out{state.scene, state.scene};
    out.before.camera = state.camera.particles.download();
    solve_first_colours(state);
    out.solved.camera = state.camera.particles.download();
    return out;
  }
};

TEST_F(FirstColours, AreWhatIsMissingInAPictureOverWhatShowsThere) {
  // Five training pictures of one camera: one of four is the first.
  const auto [before, solved] = start(100);
  const ImageFrame& frame = log_.images.front();
  const LogCamera& camera = log_.cameras.front();
  const Sensor sensor(camera.model, camera.rig_from_camera);
  const std::vector<float> truth = planar(load_image(log_, frame, camera.model));
  const std::size_t rays = sensor.ray_count();
  const auto look = [&](const Scene& scene, const auto& see) {
    SceneOnDevice on_device(test::device(), scene, TrainOptions{}.render);
    const Frame shown = on_device.render(sensor, shot_of(log_, frame), {.graded = false});
    RayGradients missing, ones;
    double squared = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      ones.feature[c].assign(rays, 1.0F);
      for (std::size_t ray = 0; ray < rays; ++ray) {
        missing.feature[c].push_back(truth[c * rays + ray] - shown.results().feature[c][ray]);
        squared += std::pow(missing.feature[c].back(), 2.0);
      }
    }
    see(on_device.gradients(shown, missing), on_device.gradients(shown, ones));
    return squared;
  };

  const Eigen::MatrixXf found = solved.camera.params - before.camera.params;
  int moved = 0;
  const double squared_before =
      look(before, [&](const Eigen::MatrixXf& missing, const Eigen::MatrixXf& ones) {
        for (Eigen::Index i = 0; i < found.rows(); ++i) {
          for (int row = kShRow; row < kShRow + 3; ++row) {
            if (before.camera.params(i, row) * kSh0 + 0.5F < 0.01F) continue;  // clipped, it has no gradient
            const float weight_px = ones(i, row) / kSh0;
            const float expected = missing(i, row) / kSh0 / (weight_px + 0.1F) / kSh0;
            EXPECT_NEAR(found(i, row), expected, 1e-3F + 1e-3F * std::abs(expected)) << i << " " << row;
            moved += std::abs(expected) > 0.01F ? 1 : 0;
          }
        }
      });
  EXPECT_GT(moved, 100);
  Eigen::MatrixXf others = found;
  others.middleCols<3>(kShRow).setZero();
  EXPECT_TRUE(others.isZero(0.0F));

  const double squared_after = look(solved, [](const Eigen::MatrixXf&, const Eigen::MatrixXf&) {});
  EXPECT_LT(squared_after, 0.75 * squared_before);
}

TEST_F(FirstColours, AreNotWorthMoreThanATrainingHas) {
  const auto [before, solved] = start(9);
  EXPECT_TRUE(solved.camera.params == before.camera.params);
}

}  // namespace
}  // namespace simuli
