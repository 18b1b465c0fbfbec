// Tests labels and flow of a trained street against its analytic ground truth.
#include "host/device/render/outputs/labels.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <iostream>
#include <stdlib.h>
#include <vector>

#include "host/core/sensors/own_time.hpp"
#include "host/device/render/outputs/flow.hpp"
#include "io/synth/street.hpp"
#include "optim/base/frames.hpp"
#include "optim/train/training.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

/// Ground truth of pixels and LiDAR rays on the car, and of motion.
class StreetTruth {
 public:
  StreetTruth(const StreetOptions& options, const Sensor& sensor)
      : street_(options.contents()), car_(options.car), sensor_(sensor) {}

  [[nodiscard]] StreetHit hit(const Shot& shot, const Eigen::Vector2d& pixel) const {
    const double share = sensor_.camera().exposure_fraction(pixel);
    const Pose world_from_camera = shot.pose_at(share);
    return street_.trace(world_from_camera.translation,
                         world_from_camera.rotation * sensor_.camera().unproject(pixel),
                         time_of(shot, share),
                         1e3);
  }
  [[nodiscard]] bool is_car(const Shot& shot, int x, int y) const {
    int on = 0;
    for (int i = 0; i < 9; ++i)
      on += hit(shot, {x + (i % 3 + 0.5) / 3.0, y + (i / 3 + 0.5) / 3.0}).on_car ? 1 : 0;
    return on > 4;
  }
  /// Returns the position of a pixel's centre in the other frame; none in the sky.
  [[nodiscard]] std::optional<Eigen::Vector2d> goes_to(const Shot& from, const Shot& to, int x, int y) const {
    const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
    const StreetHit at = hit(from, pixel);
    if (!at.hit) return std::nullopt;
    const double share = sensor_.camera().exposure_fraction(pixel);
    const Eigen::Vector3d p_world =
        from.pose_at(share) * Eigen::Vector3d(at.range * sensor_.camera().unproject(pixel));
    const auto image = image_at_own_time(sensor_.camera(), [&](double s) -> Eigen::Vector3d {
      const Eigen::Vector3d moved =
          at.on_car ? Eigen::Vector3d(car_.position(time_of(to, s)) - car_.position(time_of(from, share)))
                    : Eigen::Vector3d::Zero();
      return to.pose_at(s).inverse() * Eigen::Vector3d(p_world + moved);
    });
    if (!image) return std::nullopt;
    return image->pixel;
  }

 private:
  [[nodiscard]] static double time_of(const Shot& shot, double share) {
    return shot.time_start_s + share * (shot.time_end_s - shot.time_start_s);
  }
  Street street_;
  StreetCar car_;
  const Sensor& sensor_;
};

class LabelTruth : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "simuli_labels_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Intersection over union of the car's pixels, and sorted pixel errors.
  struct Errors {
    double iou = 0.0;
    std::vector<double> flow_px;
    [[nodiscard]] double at(double share) const {
      return flow_px.at(static_cast<std::size_t>(share * static_cast<double>(flow_px.size() - 1)));
    }
  };
  static Errors errors(const Log& log, const StreetOptions& options, const Scene& scene, std::size_t frame) {
    const LogCamera& camera = log.cameras.front();
    const Sensor sensor(camera.model, camera.rig_from_camera);
    const StreetTruth truth(options, sensor);
    const Shot from = shot_of(log, log.images.at(frame)), to = shot_of(log, log.images.at(frame + 1));
    SceneOnDevice on_device(test::device(), borrowed(scene));
    const Frame seen = on_device.render(sensor, from, {.camera_median = true, .actors = true});
    const std::vector<std::uint32_t> actors = seen.actors();
    const Flow flow = flow_of(seen, scene, to);
    std::size_t both = 0, any = 0;
    Errors out;
    for (int y = 0; y < camera.model.height; ++y) {
      for (int x = 0; x < camera.model.width; ++x) {
        const std::size_t i = static_cast<std::size_t>(y * camera.model.width + x);
        const bool is_car = truth.is_car(from, x, y);
        both += is_car && actors[i] != 0 ? 1U : 0U;
        any += is_car || actors[i] != 0 ? 1U : 0U;
        const auto at = truth.goes_to(from, to, x, y);
        if (!at || flow.pixels.at(x, y, 2) == 0.0F) continue;
        const Eigen::Vector2d found(x + 0.5 + flow.pixels.at(x, y, 0), y + 0.5 + flow.pixels.at(x, y, 1));
        out.flow_px.push_back((found - *at).norm());
      }
    }
    out.iou = static_cast<double>(both) / static_cast<double>(any);
    std::sort(out.flow_px.begin(), out.flow_px.end());
    std::cout << "frame " << frame << ": car " << any << " px, IoU " << out.iou << ", flow median "
              << out.at(0.5) << " px, 90 % " << out.at(0.9) << " px, 99 % " << out.at(0.99) << " px\n";
    return out;
  }

  std::filesystem::path folder_;
};

TEST_F(LabelTruth, MasksAndFlowAreTheStreets) {
  StreetOptions options;
  options.output = folder_ / "street.log";
  options.frames = 8;
  options.image_width = 240;
  options.image_height = 136;
  options.lidar_columns = 450;
  options.rolling_shutter = true;
  options.car.start_m = 10.0;
  const Log log = synth_street(options);
  TrainingOptions how;
  how.frames.image_scale = 1.0;
  how.train.iterations = 200;
  Training training(test::device(), log, how);
  training.run();
  const Scene scene = training.result().scene;
  const Errors found = errors(log, options, scene, 3);
  EXPECT_GE(found.iou, 0.95);
  EXPECT_LE(found.at(0.5), 0.1);
}

}  // namespace
}  // namespace simuli
