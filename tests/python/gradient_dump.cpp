// gradient_dump FILE.json: a small set, rays in the world, random weights of what they see, and our gradient
// of the weighted sum, for tensor_gradients.py.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

#include "host/device/render/scene/sensor_in_frame.hpp"
#include "tests/cl/support.hpp"

namespace simuli {
namespace {

constexpr int kParticles = 200;

std::vector<double> listed(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::json dumped(const test::SceneCase& scene, const Device& device) {
  const bool camera = scene.kind == SetKind::kCamera;
  RenderOptions options;
  options.precision = device.info().fp64 ? Precision::kDouble : Precision::kFloat;
  options.extent = Extent::kExact;
  test::SetRecipe recipe;
  recipe.count = kParticles;
  recipe.low = {camera ? 3.0 : -9.0, camera ? -3.0 : -9.0, -2.0};
  recipe.high = {9.0, camera ? 3.0 : 9.0, 2.0};
  recipe.scale_min = 0.1;
  recipe.scale_max = 0.8;
  const GaussianSet set = test::set_for(scene, recipe, 3);
  const test::Shot shot = camera ? test::shot_of(scene, 32, 24) : test::shot_of(scene, 60, 10);
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  ParticleBuffers particles(device, set, options.precision);
  RealBuffer grads(device, "parameter gradients", options.precision);
  const RayGrid& grid = rays.grid();
  const std::size_t slots = grid.frame.slots;

  nlohmann::json out{{"name", scene.name}, {"sh_degree", scene.sh_degree}, {"clamped", camera ? 3 : 1}};
  const Pose& start = shot.view.scene_from_sensor_start;
  const Pose& end = shot.view.scene_from_sensor_end;
  std::vector<double> weights(5 * slots, 0.0);
  test::Random random(11);
  for (std::size_t slot = 0; slot < slots; ++slot) {
    if (grid.ray_of_slot[slot] < 0) continue;
    const auto entry = [&](std::size_t k) { return static_cast<double>(grid.sensor_ray[k * slots + slot]); };
    const Pose pose = interpolate(start, end, entry(6));
    out["directions"].push_back(listed(pose.rotation * Eigen::Vector3d(entry(0), entry(1), entry(2))));
    out["origins"].push_back(listed(pose * Eigen::Vector3d(entry(3), entry(4), entry(5))));
    std::vector<double> of_ray;
    for (std::size_t k = 0; k < 5; ++k) {
      of_ray.push_back(random.normal());
      weights[k * slots + slot] = of_ray.back();
    }
    out["weights"].push_back(of_ray);
  }
  Pass pass = renderer.render(particles, rays, shot.view);
  pass.set_output_gradients(test::by_ray(pass.rays(), weights));
  pass.backward(particles, grads);
  const auto constants =
      sensor_in_frame(rays, start, end, options, shot.view.background, shot.view.drop).constants;
  out["kappa"] = constants.model.kappa;
  out["t_min_m"] = constants.model.t_min;
  out["t_max_m"] = constants.model.t_max;
  out["centre_m"] = listed(interpolate(start, end, 0.5).translation);
  out["background"] = shot.view.background;
  const std::vector<double> params = particles.params.download_double(), gradient = grads.download_double();
  const std::vector<std::uint32_t> keys = pass.buffers().projected.keys.download();
  for (std::size_t row = 0; row < static_cast<std::size_t>(set.params.cols()); ++row) {
    std::vector<double> values, slopes;
    for (std::size_t i = 0; i < kParticles; ++i) {
      values.push_back(params[row * particles.stride + i]);
      // What the frame culled has no gradient; of the kernels' buffers that part is not defined.
      slopes.push_back(keys[i] == 0xffffffffU ? 0.0 : gradient[row * particles.stride + i]);
    }
    out["params"].push_back(values);
    out["gradient"].push_back(slopes);
  }
  out["double"] = device.info().fp64;
  return out;
}

}  // namespace
}  // namespace simuli

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: gradient_dump FILE.json\n";
    return EXIT_FAILURE;
  }
  const simuli::Device device = simuli::Device::best();
  nlohmann::json all;
  for (const auto& scene :
       {simuli::test::kCameraSh3, simuli::test::kCameraRolling, simuli::test::kLidarMoving}) {
    all.push_back(simuli::dumped(scene, device));
  }
  std::ofstream file(argv[1]);
  file << all;
  return file.good() ? EXIT_SUCCESS : EXIT_FAILURE;
}
