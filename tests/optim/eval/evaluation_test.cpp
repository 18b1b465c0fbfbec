#include "optim/eval/evaluation.hpp"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

#include "host/base/error.hpp"
#include "host/render/scene/seen.hpp"
#include "optim/base/frames.hpp"
#include "optim/eval/sweep_pair.hpp"
#include "tests/optim/small_street.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::compare;

const EvalOptions kFull{.image_scale = 1.0};

class EvaluationTest : public test::SmallStreet {
 protected:
  /// The street's log with frame 4 replaced by what `scene` shows there.
  static Log log_of(const Scene& scene, const std::string& name) {
    Log log = log_;
    log.folder = folder_ / name;
    fs::create_directories(log.folder / "images");
    fs::create_directories(log.folder / "sweeps");
    Renderer renderer(Device::best(), RenderOptions{});
    const ImageFrame& image = log.images[4];
    const Camera& camera = log.camera(image.camera).model;
    const SensorRays rays(renderer.device(), camera, renderer.options());
    const ParticleBuffers camera_set(renderer.device(), scene.camera, Precision::kFloat);
    renderer.render(camera_set, rays, view_of(log, scene, image));
    write_image(log.folder / image.file, picture_of(renderer.results(), camera));

    const ParticleBuffers lidar_set(renderer.device(), scene.lidar, Precision::kFloat);
    SweepPair pair = render_sweep(renderer, lidar_set, log_, scene, log_.sweeps[4]);
    for (std::size_t i = 0; i < pair.recorded.range.size(); ++i) {
      const bool returns = pair.simulated.drop_probability(i) <= 0.5F;
      pair.recorded.range[i] = returns ? best_distance(pair.simulated, i) : 0.0F;
      pair.recorded.intensity[i] = returns ? std::clamp(pair.simulated.feature[0][i], 0.0F, 1.0F) : 0.0F;
    }
    write_sweep(log.folder / log.sweeps[4].file, pair.recorded);
    return log;
  }
};

TEST_F(EvaluationTest, SceneAgreesWithALogMadeOfIt) {
  const Scene scene = initial_scene();
  const Log log = log_of(scene, "self.log");
  const EvalReport r = compare(log, scene, kFull);
  EXPECT_EQ(r.images, 1U);
  EXPECT_EQ(r.sweeps, 1U);
  // Pictures are stored in 8 bits: rounding of +-1/510 alone is 59 dB.
  EXPECT_GT(r.psnr_db, 55.0);
  EXPECT_GT(r.ssim, 0.99);
  EXPECT_EQ(r.lidar.distance_median_m, 0.0);  // sweeps are stored in float
  EXPECT_EQ(r.lidar.medl2_m2, 0.0);
  EXPECT_EQ(r.lidar.mean_rel_l2, 0.0);
  EXPECT_EQ(r.lidar.intensity_rmse, 0.0);
  EXPECT_EQ(r.lidar.raydrop_accuracy, 1.0);
  EXPECT_EQ(r.lidar.chamfer_m, 0.0);
  EXPECT_GT(r.distance_expected_median_m, 0.0);  // the mean is not the median
  EXPECT_GT(r.camera_mp_per_s, 0.0);
  EXPECT_GT(r.lidar_mr_per_s, 0.0);
  EXPECT_EQ(r.image_width, 64);
  EXPECT_EQ(r.image_height, 36);
}

TEST_F(EvaluationTest, ShiftedSceneIsOffByTheShift) {
  const Scene scene = initial_scene();
  const Log log = log_of(scene, "shift.log");
  Scene nearer = scene;
  nearer.lidar.mean().col(0).array() += 0.5F;  // along the street: ranges ahead and behind change by less
  const EvalReport r = compare(log, nearer, kFull);
  EXPECT_GT(r.lidar.distance_median_m, 0.001);
  EXPECT_LT(r.lidar.distance_median_m, 0.5);
  EXPECT_NEAR(std::sqrt(r.lidar.medl2_m2), r.lidar.distance_median_m, 1e-6);
}

TEST_F(EvaluationTest, HalfSizeComparesHalfSizePictures) {
  const EvalReport r = compare(log_, initial_scene(), {.image_scale = 0.5});
  EXPECT_EQ(r.image_width, 32);
  EXPECT_EQ(r.image_height, 18);
  EXPECT_TRUE(std::isfinite(r.psnr_db));
}

TEST_F(EvaluationTest, MissingSensorsAreNaN) {
  Log log = log_;
  log.images.clear();
  const EvalReport r = compare(log, initial_scene(), kFull);
  EXPECT_TRUE(std::isnan(r.psnr_db));
  EXPECT_TRUE(std::isnan(r.camera_mp_per_s));
  EXPECT_TRUE(std::isfinite(r.lidar.distance_median_m));
}

TEST_F(EvaluationTest, NothingHeldOutOrBadOptionsAreRefused) {
  Log log = log_;
  log.images.resize(4);
  log.sweeps.resize(4);
  EXPECT_THROW((void)compare(log, initial_scene(), kFull), Error);
  EvalOptions options = kFull;
  options.held_out_every = 0;
  EXPECT_EQ(compare(log, initial_scene(), options).images, 4U);
  options.held_out_every = 1;
  EXPECT_THROW((void)compare(log, initial_scene(), options), Error);
  options = kFull;
  options.timed_renders = 0;
  EXPECT_THROW((void)compare(log_, initial_scene(), options), Error);
}

TEST(ScaledCamera, SidesAreRoundedUp) {
  const Camera camera{"c", 1242, 375, 700.0, 700.0, 600.0, 180.0, ShutterKind::kGlobal};
  const Camera half = scaled_camera(camera, 0.5);
  EXPECT_EQ(half.width, 621);
  EXPECT_EQ(half.height, 188);
  EXPECT_DOUBLE_EQ(half.fy, 700.0 * 188.0 / 375.0);
  EXPECT_EQ(scaled_camera(camera, 0.1).width, 125);
  EXPECT_THROW((void)scaled_camera(camera, 0.0), Error);
  EXPECT_THROW((void)scaled_camera(camera, std::nan("")), Error);
}

}  // namespace
}  // namespace simuli
