// Program simuli_host_bench: host work per frame, with Google Benchmark. Run with --benchmark_filter=NAME.
#include <benchmark/benchmark.h>
#include <cstddef>
#include <filesystem>

#include "bench/particles/particle_street.hpp"
#include "host/device/render/rays/ray_grid.hpp"
#include "host/device/runtime/device.hpp"
#include "io/splat/ply.hpp"
#include "optim/base/metrics.hpp"

namespace simuli {
namespace {

/// A ray grid is built once per camera,
void BM_RayGridCamera(benchmark::State& state) {
  Camera camera;
  camera.name = "bench";
  camera.width = static_cast<int>(state.range(0));
  camera.height = camera.width * 9 / 16;
  camera.fx = camera.fy = 0.6 * camera.width;
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  for (auto _ : state) benchmark::DoNotOptimize(make_ray_grid(camera, RenderOptions{}));
  state.SetItemsProcessed(state.iterations() * camera.width * camera.height);
}
BENCHMARK(BM_RayGridCamera)->Arg(640)->Arg(1920)->Unit(benchmark::kMillisecond);

/// and once per sweep, since measured rays differ between sweeps.
void BM_RayGridLidar(benchmark::State& state) {
  const Lidar lidar = builtin_lidar("generic64");
  const LidarRays rays = nominal_rays(lidar);
  const Device device = Device::best();
  for (auto _ : state) benchmark::DoNotOptimize(make_ray_grid(device, lidar, rays));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(lidar.ray_count()));
}
BENCHMARK(BM_RayGridLidar)->Unit(benchmark::kMillisecond);

void BM_PlyRoundTrip(benchmark::State& state) {
  const GaussianSet set = street_particles(SetKind::kCamera, 3, state.range(0), 1);
  const auto file = std::filesystem::temp_directory_path() / "simuli_host_bench.ply";
  for (auto _ : state) {
    write_gaussians_ply(file, set);
    benchmark::DoNotOptimize(read_gaussians_ply(file, SetKind::kCamera));
  }
  std::filesystem::remove(file);
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_PlyRoundTrip)->Arg(100'000)->Unit(benchmark::kMillisecond);

void BM_Ssim(benchmark::State& state) {
  Image a(621, 188, 3);
  Image b(621, 188, 3);
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    a.data[i] = static_cast<float>(i % 97) / 97.0F;
    b.data[i] = static_cast<float>(i % 89) / 89.0F;
  }
  for (auto _ : state) benchmark::DoNotOptimize(ssim(a, b));
}
BENCHMARK(BM_Ssim)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace simuli

BENCHMARK_MAIN();
