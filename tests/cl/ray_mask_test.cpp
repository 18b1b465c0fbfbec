// Tests ray-based culling: the mask against a count of the rays, and equal bits of sweeps with and without
// culling.
#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

/// Selection of requested rays.
struct Request {
  const char* name;
  std::function<bool(std::size_t ray, std::size_t rays, std::size_t columns)> wants;
};

const std::vector<Request>& requests() {
  static const std::vector<Request> kRequests{
      {"all", [](std::size_t, std::size_t, std::size_t) { return true; }},
      {"1 in 16", [](std::size_t ray, std::size_t, std::size_t) { return ray % 16 == 5; }},
      {"every 16th firing",
       [](std::size_t ray, std::size_t, std::size_t columns) { return ray % columns % 16 == 0; }},
      {"every 16th beam",
       [](std::size_t ray, std::size_t, std::size_t columns) { return ray / columns % 16 == 3; }},
      {"an eighth of the sweep",
       [](std::size_t ray, std::size_t, std::size_t columns) { return ray % columns < columns / 8; }},
      {"one ray", [](std::size_t ray, std::size_t rays, std::size_t) { return ray == rays / 2; }},
      {"none", [](std::size_t, std::size_t, std::size_t) { return false; }},
  };
  return kRequests;
}

std::vector<bool> flags_of(const Request& request, std::size_t rays, std::size_t columns) {
  std::vector<bool> flags(rays);
  for (std::size_t ray = 0; ray < rays; ++ray) flags[ray] = request.wants(ray, rays, columns);
  return flags;
}

TEST(RayMask, AreasCountOccupiedCells) {
  const Device& device = test::device();
  const Lidar lidar = test::small_lidar(20, 150);
  const SensorRays all(device, lidar, nominal_rays(lidar), paper_options());
  for (const Request& request : requests()) {
    SCOPED_TRACE(request.name);
    const SensorRays rays = all.requested(flags_of(request, 3000, 150));
    const auto columns = static_cast<std::size_t>(rays.model().mask_columns);
    const std::size_t rows = std::string(request.name) == "all" ? 8 : 20;
    const double first = rays.grid().model.tile_first;
    const double width = (rays.grid().model.tile_last - first) / rays.model().mask_columns;
    const auto mask_row_of_row = rays.buffers().requested.mask_row_of_row.download();
    // Position of each requested ray; a ray within rounding of an edge may be in either cell.
    constexpr double kFloat_rad = 2e-6;
    std::vector<int> certain(rows * columns, 0), possible(rows * columns, 0);
    const auto cell = [&](double u, std::size_t row) {
      const double place = std::clamp((u - first) / width, 0.0, static_cast<double>(columns - 1));
      return mask_row_of_row[row] * columns + static_cast<std::size_t>(place);
    };
    const auto& grid = rays.grid();
    for (std::size_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
      const std::int32_t ray = grid.ray_of_slot[slot];
      if (ray < 0 || !request.wants(static_cast<std::size_t>(ray), 3000, 150)) continue;
      const double u = static_cast<double>(grid.u[slot]);
      const auto row = static_cast<std::size_t>(ray) / 150;
      const std::size_t low = cell(u - kFloat_rad, row), high = cell(u + kFloat_rad, row);
      possible[low] = possible[high] = 1;
      if (low == high) certain[low] = 1;
    }
    const auto areas = rays.buffers().requested.areas.download();
    ASSERT_EQ(areas.size(), (rows + 1) * (columns + 1));
    for (std::size_t y = 0; y < rows; ++y) {
      for (std::size_t x = 0; x < columns; ++x) {
        const std::uint32_t* corner = areas.data() + y * (columns + 1) + x;
        const auto here = static_cast<int>(corner[columns + 2] - corner[columns + 1] - corner[1] + corner[0]);
        ASSERT_GE(here, certain[y * columns + x]) << x << ", " << y;
        ASSERT_LE(here, possible[y * columns + x]) << x << ", " << y;
      }
    }
    EXPECT_EQ(rays.can_cull(), areas.back() < rows * columns);
  }
}

TEST(RayMask, SomeRaysGetARowPerBeamAndTwoColumnsPerFiring) {
  const Device& device = test::device();
  const Lidar lidar = test::small_lidar(20, 900);
  const SensorRays rays(device, lidar, nominal_rays(lidar), paper_options());
  const auto cells = [](const SensorRays& of) { return of.buffers().requested.areas.count(); };
  std::vector<bool> some(lidar.ray_count(), true);
  some[7] = false;
  EXPECT_EQ(cells(rays.requested(some)), std::size_t{21} * 1801);
  EXPECT_EQ(cells(rays.requested(std::vector<bool>(lidar.ray_count(), true))), std::size_t{9} * 1601);
  EXPECT_EQ(cells(rays), std::size_t{9} * 1601);
}

TEST(RayMask, RowsHoldEqualNumbersOfBeams) {
  const Device& device = test::device();
  Lidar lidar = test::small_lidar(16, 40);
  for (std::size_t r = 0; r < 12; ++r) lidar.rows[r].elevation = 0.1 - 0.001 * static_cast<double>(r);
  const SensorRays rays(device, lidar, nominal_rays(lidar), paper_options());
  const auto row = rays.buffers().requested.mask_row_of_row.download();
  for (std::size_t r = 0; r < 16; ++r) EXPECT_EQ(row[r], r / 2);
}

/// Returns particles of all sizes around the sensor, some on the seam, at the poles and enclosing the sensor.
GaussianSet crowd(std::uint64_t seed, int degree, SetKind kind = SetKind::kLidar) {
  test::SetRecipe recipe;
  recipe.kind = kind;
  recipe.sh_degree = degree;
  recipe.count = 500;
  recipe.low = {-25, -25, -4};
  recipe.high = {25, 25, 5};
  recipe.scale_min = 0.005;
  recipe.scale_max = 0.6;
  GaussianSet set = test::random_set(recipe, seed);
  test::Random random(seed + 1);
  for (Eigen::Index i = 0; i < 60; ++i) {
    const float range = static_cast<float>(random.uniform(1.0, 20.0));
    const float aside = static_cast<float>(random.uniform(-0.1, 0.1));
    const float sign = i % 2 == 0 ? 1.0F : -1.0F;
    if (i < 20) set.mean().row(i) << sign * range, aside, aside;  // ahead and behind: the cuts of the tables
    if (i >= 20 && i < 40) set.mean().row(i) << aside, aside, sign * range;  // above and below
    if (i >= 40) set.mean().row(i) << aside, aside, aside;                   // around
  }
  return set;
}

struct Sweep {
  std::vector<std::uint32_t> bits;  // of all outputs of all rays
  std::size_t visible = 0;
};

Sweep sweep_of(Renderer& renderer,
               const ParticleBuffers& particles,
               const SensorRays& rays,
               const View& view) {
  const Pass pass = renderer.render(particles, rays, view);
  const RayResults results = pass.results();
  Sweep sweep;
  for (const auto* values : {&results.feature[0],
                             &results.feature[1],
                             &results.feature[2],
                             &results.transmittance,
                             &results.distance,
                             &results.median}) {
    for (const float value : *values) sweep.bits.push_back(std::bit_cast<std::uint32_t>(value));
  }
  sweep.visible = pass.buffers().binned.visible;
  return sweep;
}

/// Sweeps with and without culling, and the number of culled visible particles.
class Comparison {
 public:
  explicit Comparison(const RenderOptions& options)
      : off_(with(options, Culling::kOff)),
        auto_(with(options, Culling::kAuto)),
        without_culling_(device_, off_),
        with_culling_(device_, auto_) {}

  /// Asserts equal bits of both.
  void expect_same(const Lidar& lidar,
                   const View& view,
                   std::uint64_t seed,
                   const std::vector<Request>& requested) {
    expect_same(lidar.name,
                crowd(seed, 0),
                SensorRays(device_, lidar, nominal_rays(lidar), off_),
                SensorRays(device_, lidar, nominal_rays(lidar), auto_),
                static_cast<std::size_t>(lidar.columns),
                view,
                requested);
  }
  void expect_same(const Camera& camera,
                   const View& view,
                   std::uint64_t seed,
                   const std::vector<Request>& requested) {
    expect_same(camera.name,
                crowd(seed, 0, SetKind::kCamera),
                SensorRays(device_, camera, off_),
                SensorRays(device_, camera, auto_),
                static_cast<std::size_t>(camera.width),
                view,
                requested);
  }

  std::size_t kept = 0, dropped = 0;

 private:
  void expect_same(const std::string& sensor,
                   const GaussianSet& set,
                   const SensorRays& all,
                   const SensorRays& marked,
                   std::size_t columns,
                   const View& view,
                   const std::vector<Request>& requested) {
    const ParticleBuffers particles(device_, set, Precision::kFloat);
    for (const Request& request : requested) {
      const std::string name = request.name;
      const std::vector<bool> flags = flags_of(request, all.grid().rays, columns);
      const Sweep expected = sweep_of(without_culling_, particles, all.requested(flags), view);
      const Sweep culled = sweep_of(with_culling_, particles, marked.requested(flags), view);
      ASSERT_EQ(culled.bits, expected.bits) << sensor << ", " << name;
      ASSERT_LE(culled.visible, expected.visible);
      if (name == "none") {
        ASSERT_EQ(culled.visible, 0U) << sensor;
      }
      kept += culled.visible;
      dropped += expected.visible - culled.visible;
    }
  }

  static RenderOptions with(RenderOptions options, Culling culling) {
    options.culling = culling;
    return options;
  }
  Device device_ = test::device();
  RenderOptions off_ = paper_options(), auto_ = off_;
  Renderer without_culling_, with_culling_;
};

View drive() {
  View view;
  view.scene_from_sensor_end.translation = {3.0, -0.5, 0.05};
  view.scene_from_sensor_end.rotation =
      Eigen::AngleAxisd(kPi / 15.0, Eigen::Vector3d(0.05, 0.1, 1.0).normalized());
  return view;
}

TEST(RayMask, CullingChangesNoBitOfAnySensorsSweep) {
  Comparison comparison({});
  const std::vector<Request> few{requests()[0], requests()[1], requests()[4]};
  std::uint64_t seed = 1;
  for (const std::string& name : builtin_lidar_names()) {
    for (const View& view : {View{}, drive()}) {
      comparison.expect_same(builtin_lidar(name), view, seed++, few);
      if (HasFatalFailure()) return;
    }
  }
  std::cout << comparison.dropped << " of " << comparison.kept + comparison.dropped
            << " visible particles dropped\n";
  EXPECT_GT(comparison.dropped, comparison.kept / 4);  // otherwise nothing is tested
}

// Ray offsets and partial revolutions, at rest and in motion.
void expect_no_bit_changes_in_spans(const RenderOptions& options) {
  Comparison comparison(options);
  for (const double span : {2.0 * kPi, 5.0, 0.7}) {
    Lidar lidar = test::small_lidar(20, 300);
    lidar.azimuth_span = span;
    for (std::size_t r = 0; r < lidar.rows.size(); ++r)
      lidar.rows[r].azimuth_offset = r % 3 == 0 ? 0.05 : -0.02;
    for (const View& view : {View{}, drive()}) {
      for (std::uint64_t seed = 100; seed < 105; ++seed) {
        comparison.expect_same(lidar, view, seed, requests());
        if (testing::Test::HasFatalFailure()) return;
      }
    }
  }
  EXPECT_GT(comparison.dropped, comparison.kept / 4);
}

TEST(RayMask, NorInOtherSpansAndScenes) { expect_no_bit_changes_in_spans(paper_options()); }

TEST(RayMask, NorInOtherShapesAndExtents) {
  RenderOptions gpu = paper_options(), exact = gpu;
  gpu.shape = test::kGpuShape;
  exact.extent = Extent::kExact;
  for (const RenderOptions& options : {gpu, exact}) expect_no_bit_changes_in_spans(options);
}

// Cameras use the rectangle around the pixels, also for wrapped pictures.
TEST(RayMask, NorInPictures) {
  Comparison comparison(paper_options());
  Camera camera = test::shot_of(test::kCameraRolling, 150, 20).camera;
  Camera panorama = camera;
  panorama.name = "panorama";
  panorama.lens = Lens(LensKind::kEquirectangular, {});
  panorama.fx = panorama.fy = panorama.width / (2.0 * kPi);
  for (const Camera& of : {camera, panorama}) {
    for (const View& view : {View{}, drive()}) {
      comparison.expect_same(of, view, 7, requests());
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  EXPECT_GT(comparison.dropped, comparison.kept / 4);
}

TEST(RayMask, AFullMaskIsNotAsked) {
  const Device& device = test::device();
  RenderOptions options = paper_options();
  const Lidar lidar = builtin_lidar("generic64");
  const SensorRays rays(device, lidar, nominal_rays(lidar), options);
  EXPECT_GT(rays.model().mask_columns, 0.0);
  EXPECT_FALSE(rays.can_cull());
  const std::vector<bool> some =
      flags_of(requests()[1], lidar.ray_count(), static_cast<std::size_t>(lidar.columns));
  EXPECT_TRUE(rays.requested(some).can_cull());
  EXPECT_FALSE(rays.requested(std::vector<bool>(lidar.ray_count(), true)).can_cull());
  options.culling = Culling::kOff;
  const SensorRays off(device, lidar, nominal_rays(lidar), options);
  EXPECT_FALSE(off.requested(some).can_cull());
}

void expect_what_all_see(const test::SceneCase& scene_case) {
  const Device& device = test::device();
  const test::Shot shot = test::shot_of(scene_case, 150, 20);
  Renderer renderer(device, paper_options());
  const ParticleBuffers particles(device, crowd(3, 1, shot.kind), Precision::kFloat);
  const SensorRays rays = shot.on(device, paper_options());
  const RayResults full = renderer.render(particles, rays, shot.view).results();
  for (const Request& request : requests()) {
    const SensorRays some = rays.requested(flags_of(request, 3000, 150));
    const RayResults part = renderer.render(particles, some, shot.view).results();
    for (std::size_t ray = 0; ray < 3000; ++ray) {
      const bool wanted = request.wants(ray, 3000, 150);
      ASSERT_EQ(part.transmittance[ray], wanted ? full.transmittance[ray] : 1.0F)
          << request.name << " " << ray;
      ASSERT_EQ(part.distance[ray], wanted ? full.distance[ray] : 0.0F) << request.name << " " << ray;
      ASSERT_EQ(part.feature[1][ray], wanted ? full.feature[1][ray] : shot.view.background[1]) << ray;
    }
  }
  EXPECT_THROW((void)rays.requested(std::vector<bool>(10, true)), Error);
}

TEST(RayMask, RequestedRaysSeeWhatTheyDoInAFullSweep) { expect_what_all_see(test::kLidarMoving); }
TEST(RayMask, RequestedPixelsSeeWhatTheyDoInAFullPicture) { expect_what_all_see(test::kCameraRolling); }

}  // namespace
}  // namespace simuli
