// Derivatives of what rays see by the particles, against differences of frames.
#include <cmath>
#include <vector>

#include "tests/api/small_scene.hpp"

namespace simuli {
namespace {

class Gradients : public testing::TestWithParam<bool> {
 protected:
  Gradients()
      : file_(scene_with_actor()), rig_(file_), sensor_(rig_.find(GetParam() ? "front" : "velodyne_vlp16")) {
    if (GetParam()) sensor_ = sensor_.resized(24, 18);
    // Seen: one of the background, one of the actor; far behind the sensor: one that is culled.
    for (GaussianSet* set : {&file_.scene.camera, &file_.scene.lidar}) {
      const Eigen::MatrixXf two = set->params;
      set->params.resize(3, two.cols());
      set->params << two, two.row(0);
      set->mean().row(2) << (GetParam() ? -50.0F : 5e5F), 0.0F, 0.0F;
      set->actor.push_back(0);
      set->opacity_logit().setConstant(0.5F);
      set->sh(0) *= 0.1F;
    }
    // Cuts are steps: a difference would see rays enter and leave.
    options_.alpha_cut = 1e-9;
    options_.transmittance_cut = 0.0;
    if (Device::best().info().fp64) options_.precision = Precision::kDouble;
  }
  [[nodiscard]] GaussianSet& set(Scene& scene) const { return GetParam() ? scene.camera : scene.lidar; }
  [[nodiscard]] Shot shot() const { return Shot::along(file_.world_from_rig, sensor_, 0.2); }
  static double weight(std::size_t ray, std::size_t quantity) {
    // Not around 0: over many rays of a smooth function that would be none.
    return 1.0 + std::sin(0.7 * static_cast<double>(ray) + static_cast<double>(quantity));
  }
  [[nodiscard]] RayGradients weights() const {
    RayGradients out;
    for (std::size_t i = 0; i < sensor_.ray_count(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) out.feature[c].push_back(static_cast<float>(weight(i, c)));
      out.transmittance.push_back(static_cast<float>(weight(i, 3)));
      out.distance.push_back(static_cast<float>(0.1 * weight(i, 4)));
    }
    return out;
  }
  [[nodiscard]] double loss(const RayResults& r) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < r.rays; ++i) {
      for (std::size_t c = 0; c < 3; ++c) sum += weight(i, c) * static_cast<double>(r.feature[c][i]);
      sum += weight(i, 3) * static_cast<double>(r.transmittance[i]);
      sum += 0.1 * weight(i, 4) * static_cast<double>(r.distance[i]);
    }
    return sum;
  }

  SceneFile file_;
  SensorRig rig_;
  Sensor sensor_;
  RenderOptions options_ = options_of(Quality::kBalanced);
};

TEST_P(Gradients, AreThoseOfDifferences) {
  SceneOnDevice scene(Device::best(), file_.scene, options_);
  // Frames on the way in between must not matter.
  const Frame frame = scene.render(sensor_, shot());
  (void)scene.render(sensor_, Shot::along(file_.world_from_rig, sensor_, 0.7));
  const Eigen::MatrixXf gradients = scene.gradients(frame, weights());
  ASSERT_EQ(gradients.rows(), 3);
  ASSERT_EQ(gradients.cols(), set(file_.scene).params.cols());
  EXPECT_TRUE((gradients.row(2).array() == 0.0F).all());
  constexpr float kStep = 0.004F;
  const double largest = static_cast<double>(gradients.cwiseAbs().maxCoeff());
  ASSERT_GT(largest, 0.01);
  for (Eigen::Index particle = 0; particle < 2; ++particle) {
    for (const Eigen::Index row : {0, 1, 2, 3, 4, 5, 10, 11, 12, 13}) {
      double apart[2];
      for (const int side : {0, 1}) {
        Scene moved = file_.scene;
        set(moved).params(particle, row) += side == 0 ? kStep : -kStep;
        scene.set_scene(std::move(moved));
        apart[side] = loss(scene.render(sensor_, shot()).results());
      }
      const double slope = (apart[0] - apart[1]) / (2.0 * static_cast<double>(kStep));
      EXPECT_NEAR(static_cast<double>(gradients(particle, row)), slope, 0.03 * largest)
          << "particle " << particle << ", parameter " << row;
    }
  }
}

TEST_P(Gradients, OfOtherFramesAreRefused) {
  SceneOnDevice scene(Device::best(), file_.scene);
  const auto says = [&](const Frame& frame, const RayGradients& given) {
    try {
      (void)scene.gradients(frame, given);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage);
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  const Frame frame = scene.render(sensor_, shot());
  RayGradients given = weights();
  given.transmittance.pop_back();
  EXPECT_NE(says(frame, given).find("one for each of"), std::string::npos);
  given.transmittance.push_back(std::nanf(""));
  EXPECT_NE(says(frame, given).find("finite"), std::string::npos);
  const RenderOptions options = options_of(Quality::kReference);
  EXPECT_NE(says(scene.render(sensor_, shot(), {.options = options}), weights())
                .find("render.sh_direction: found ray"),
            std::string::npos);
  scene.set_scene(file_.scene);
  EXPECT_NE(says(frame, weights()).find("another scene"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(OfBoth, Gradients, testing::Bool(), [](const auto& of) {
  return std::string(of.param ? "Camera" : "Lidar");
});

}  // namespace
}  // namespace simuli
