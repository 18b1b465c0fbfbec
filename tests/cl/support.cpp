#include "tests/cl/support.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <ostream>
#include <string>

namespace simuli::test {

void PrintTo(const SceneCase& scene_case, std::ostream* out) { *out << scene_case.name; }

SensorRays Shot::on(const Device& device, const RenderOptions& options) const {
  return kind == SetKind::kCamera ? SensorRays(device, camera, options)
                                  : SensorRays(device, lidar, rays, options);
}

reference::Sensor Shot::reference() const {
  return kind == SetKind::kCamera
             ? reference::Sensor::of(camera, view.scene_from_sensor_start, view.scene_from_sensor_end)
             : reference::Sensor::of(lidar, rays, view.scene_from_sensor_start, view.scene_from_sensor_end);
}

Shot shot_of(const SceneCase& scene_case, int width, int height) {
  Shot shot;
  shot.kind = scene_case.kind;
  Pose scene_from_sensor;
  if (scene_case.kind == SetKind::kCamera) {
    scene_from_sensor = forward_from_camera();
    shot.camera =
        small_camera(width, height, scene_case.moving ? ShutterKind::kTopToBottom : ShutterKind::kGlobal);
  } else {
    shot.lidar = small_lidar(height, width);
    if (scene_case.levers) {
      for (std::size_t r = 0; r < shot.lidar.rows.size(); ++r) {
        shot.lidar.rows[r].vertical_offset = 0.1 + 0.003 * static_cast<double>(r);
      }
    }
    shot.rays = nominal_rays(shot.lidar);
  }
  shot.view.scene_from_sensor_start = scene_from_sensor;
  shot.view.scene_from_sensor_end = scene_from_sensor;
  if (scene_case.moving) {
    const Eigen::Vector3d axis = Eigen::Vector3d(0.2, 0.9, 0.4).normalized();
    Pose& end = shot.view.scene_from_sensor_end;
    end.translation += Eigen::Vector3d(0.6, 0.1, -0.05);
    end.rotation = scene_from_sensor.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(0.06, axis));
  }
  shot.view.background = {0.2F, -1.0F, 1.5F};
  return shot;
}

GaussianSet set_for(const SceneCase& scene_case, SetRecipe recipe, std::uint64_t seed) {
  recipe.kind = scene_case.kind;
  recipe.sh_degree = scene_case.sh_degree;
  return random_set(recipe, seed);
}

std::vector<double> outputs(const Pass& pass) {
  std::vector<double> out = pass.buffers().blended.out.download_double();
  out.resize(std::size_t{5} * pass.frame().slots);  // the median distance has no gradient
  return out;
}

std::vector<double> by_ray(const SensorRays& rays, const std::vector<double>& values) {
  const RayGrid& grid = rays.grid();
  const std::size_t slots = grid.frame.slots, channels = values.size() / slots;
  std::vector<double> out(channels * grid.rays, 0.0);
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const std::int32_t ray = grid.ray_of_slot[slot];
    for (std::size_t c = 0; c < channels && ray >= 0; ++c) {
      out[c * grid.rays + static_cast<std::size_t>(ray)] = values[c * slots + slot];
    }
  }
  return out;
}

RayCounts expect_same_rays(const RayResults& results,
                           const std::vector<reference::RayResult>& expected,
                           SetKind kind,
                           const Tolerance& tolerance) {
  RayCounts counts;
  std::map<std::string, double> worst;
  EXPECT_EQ(results.rays, expected.size());
  for (std::size_t i = 0; i < std::min(results.rays, expected.size()); ++i) {
    const reference::RayResult& ray = expected[i];
    if (!(ray.margin >= tolerance.decided)) continue;
    counts.compared += 1;
    counts.covered += ray.contributors > 0 ? 1 : 0;
    bool same = true;
    const auto compare = [&](const char* what, float found, double right, double within) {
      const double error = std::abs(static_cast<double>(found) - right);
      worst[what] = std::max(worst[what], error);
      if (error <= within) return;
      ADD_FAILURE() << "ray " << i << ": " << what << ' ' << found << ", expected " << right << " +- "
                    << within;
      same = false;
    };
    for (int k = 0; k < 3; ++k) compare("feature", results.feature[k][i], ray.feature[k], tolerance.feature);
    compare("transmittance", results.transmittance[i], ray.transmittance, tolerance.transmittance);
    compare("distance", results.distance[i], ray.distance, tolerance.distance_m);
    if (kind == SetKind::kLidar && ray.median_margin > tolerance.decided) {
      compare("median", results.median[i], ray.median_distance, tolerance.distance_m);
    }
    if (!same) break;
  }
  // For bench/drivers.py, which compares OpenCL implementations.
  for (const auto& [what, error] : worst) {
    testing::Test::RecordProperty("worst_" + what, fmt::format("{:.3g}", error));
  }
  if (counts.compared > 0) counts.covered /= counts.compared;
  if (!expected.empty()) counts.compared /= static_cast<double>(expected.size());
  return counts;
}

void expect_drop_logits(const RayResults& results, const View& view, SetKind kind) {
  if (kind == SetKind::kCamera) {
    EXPECT_TRUE(results.drop_logit.empty());
    return;
  }
  ASSERT_EQ(results.drop_logit.size(), results.rays);
  for (std::size_t i = 0; i < results.rays; ++i) {
    const reference::RayResult ray{
        .feature = {results.feature[0][i], results.feature[1][i], results.feature[2][i]},
        .transmittance = results.transmittance[i],
        .distance = results.distance[i]};
    // 24 bits of logits up to 30 and of a transmittance, times parameters up to 3 in two layers.
    const double expected = reference::drop_logit(view.drop, ray);
    ASSERT_NEAR(results.drop_logit[i], expected, 2e-4 * (1.0 + std::abs(expected))) << i;
    const double p = 1.0 / (1.0 + std::exp(-static_cast<double>(results.drop_logit[i])));
    ASSERT_NEAR(results.drop_probability(i), p, 1e-6) << i;
  }
}

bool has_double(const Device& device) { return device.info().fp64; }

}  // namespace simuli::test
