// Tests procedure 1 on the device for all tables: properties of all tilings.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <string>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/device/render/rays/lidar_tiles.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace lidar_tiling_test {

constexpr double kFloat_rad = 2e-6;  // positions of up to 7 rad in float, scaled and floored

/// Expects that each ray has its own slot, in the tile of its beam and position and in its beam's slot rows,
/// and that no tile exceeds its slots. row_of_ray[rays].
void expect_sound(const LidarTiles& tiling,
                  const std::vector<std::uint32_t>& row_of_ray,
                  const std::vector<float>& x) {
  ASSERT_EQ(tiling.slot_of_ray.size(), x.size());
  ASSERT_GE(tiling.row_slots, 1U);
  ASSERT_EQ(tiling.tile_rows.front(), 0U);
  ASSERT_EQ(tiling.tile_rows.back(), tiling.rows());
  std::vector<bool> taken(tiling.tiles() * SIM_TILE_RAYS, false);
  for (std::size_t ray = 0; ray < x.size(); ++ray) {
    const std::uint32_t slot = tiling.slot_of_ray[ray];
    ASSERT_LT(slot, taken.size());
    ASSERT_FALSE(taken[slot]) << "ray " << ray;
    taken[slot] = true;
    const std::uint32_t tile = slot / SIM_TILE_RAYS;
    const std::uint32_t ray_block = slot % SIM_TILE_RAYS / SIM_RAY_BLOCK;
    ASSERT_EQ(tiling.tile_rows[tile / tiling.columns] + ray_block / tiling.row_slots, row_of_ray[ray]);
    const double place = static_cast<double>(x[ray]);
    ASSERT_GE(place, tiling.column_begin(tile % tiling.columns) - kFloat_rad) << "ray " << ray;
    ASSERT_LE(place, tiling.column_begin(tile % tiling.columns + 1) + kFloat_rad) << "ray " << ray;
  }
  for (std::size_t ty = 0; ty + 1 < tiling.tile_rows.size(); ++ty) {
    const std::uint32_t rows = tiling.tile_rows[ty + 1] - tiling.tile_rows[ty];
    ASSERT_GE(rows, 1U);
    ASSERT_LE(rows * tiling.row_slots * SIM_RAY_BLOCK, SIM_TILE_RAYS);
    for (std::uint32_t row = tiling.tile_rows[ty]; row < tiling.tile_rows[ty + 1]; ++row)
      ASSERT_EQ(tiling.tile_row_of_row[row], ty);
  }
  ASSERT_LE(tiling.columns, 65535U);
}

/// Elevations and positions for a ray grid, from azimuths that increase along the spin.
struct Rays {
  std::vector<float> elevation;  // of rows
  std::vector<float> x;
  std::vector<std::uint32_t> row_of_ray;
};

Rays rays_of(const Lidar& lidar) {
  Rays rays;
  for (int row = 0; row < lidar.row_count(); ++row) {
    rays.elevation.push_back(static_cast<float>(lidar.rows[static_cast<std::size_t>(row)].elevation));
    for (int column = 0; column < lidar.columns; ++column) {
      const double turned = lidar.spin_sign() * (lidar.azimuth(row, column) - lidar.azimuth_first);
      rays.x.push_back(static_cast<float>(turned));
      rays.row_of_ray.push_back(static_cast<std::uint32_t>(row));
    }
  }
  return rays;
}

TEST(LidarTiling, EveryTable) {
  const Device& device = test::device();
  for (const std::string& name : builtin_lidar_names()) {
    SCOPED_TRACE(name);
    const Rays rays = rays_of(builtin_lidar(name));
    const LidarTiles tiling = tile_rows_of_rays(device, name, rays.elevation, rays.x);
    expect_sound(tiling, rays.row_of_ray, rays.x);
    if (HasFatalFailure()) return;
    // No boundary splits beams of one elevation, and k of n boundaries have k / n of the beams above, up to
    // one beam and the beams of its elevation.
    const std::size_t tiles = tiling.tile_rows.size() - 1;
    if (tiles != (rays.elevation.size() + 7) / 8) continue;  // beams collapsed, or a tile had to be cut
    const double rows = static_cast<double>(tiling.rows());
    for (std::size_t k = 1; k < tiles; ++k) {
      const std::uint32_t row = tiling.tile_rows[k];
      ASSERT_GT(rays.elevation[row - 1], rays.elevation[row]);
      const auto same = [&](float e) { return std::count(rays.elevation.begin(), rays.elevation.end(), e); };
      ASSERT_NEAR(row,
                  rows * static_cast<double>(k) / static_cast<double>(tiles),
                  static_cast<double>(same(rays.elevation[row]) + same(rays.elevation[row - 1])));
    }
  }
}

TEST(LidarTiling, OddSensors) {
  const Device& device = test::device();
  const auto check = [&](const std::vector<float>& elevation, std::uint32_t columns, double span) {
    Rays rays;
    rays.elevation = elevation;
    for (std::uint32_t row = 0; row < elevation.size(); ++row) {
      for (std::uint32_t column = 0; column < columns; ++column) {
        rays.x.push_back(static_cast<float>(span * column / columns));
        rays.row_of_ray.push_back(row);
      }
    }
    SCOPED_TRACE(std::to_string(elevation.size()) + " beams of " + std::to_string(columns));
    expect_sound(tile_rows_of_rays(device, "odd", rays.elevation, rays.x), rays.row_of_ray, rays.x);
  };
  check({0.1F}, 1, 0.0);                                        // one ray
  check({-0.3F}, 1800, 6.28);                                   // one beam
  check({0.2F, 0.1F}, 3, 0.5);                                  // fewer beams than tiles
  check(std::vector<float>(40, 0.0F), 100, 6.28);               // all of one elevation
  check({0.2F, 0.2F, 0.2F, 0.1F, 0.1F, -0.4F}, 500, 0.8);       // some of one elevation
  check({1.0F, 0.9999F, 0.9998F, 0.9997F, -1.0F}, 2000, 3.14);  // four in a bin or two, one apart
}

TEST(LidarTiling, RaysTooUnevenAreRefused) {
  const Device& device = test::device();
  const std::vector<float> bundled(4000, 0.5F);
  EXPECT_THROW((void)tile_rows_of_rays(device, "bundled", {0.1F, 0.0F}, bundled), Error);
}

TEST(LidarTiling, ListsAreTiledAlongBothAxes) {
  const Device& device = test::device();
  test::Random random(7);
  for (const std::size_t count : {1U, 40U, 20000U}) {
    std::vector<float> elevation, x;
    for (std::size_t i = 0; i < count; ++i) {  // dense in the middle of both axes
      elevation.push_back(static_cast<float>(0.1 * random.normal()));
      x.push_back(static_cast<float>(1.5 + 0.2 * random.normal()));
    }
    SCOPED_TRACE(std::to_string(count) + " rays");
    const LidarTiles tiling = tile_ray_list(device, "list", elevation, x);
    std::vector<std::uint32_t> row_of_ray(count);
    for (std::uint32_t row = 0; row < tiling.rows(); ++row) {
      for (std::uint32_t i = tiling.row_starts[row]; i < tiling.row_starts[row + 1]; ++i)
        row_of_ray[tiling.order[i]] = row;
    }
    expect_sound(tiling, row_of_ray, x);
    if (HasFatalFailure()) return;
    for (std::size_t i = 1; i < count; ++i)
      ASSERT_GE(elevation[tiling.order[i - 1]], elevation[tiling.order[i]]);
    if (count < 20000) continue;
    // Also equal shares in azimuth: uniform columns would contain most rays in the middle third.
    std::vector<std::size_t> per_column(tiling.columns, 0);
    for (const std::uint32_t slot : tiling.slot_of_ray) ++per_column[slot / SIM_TILE_RAYS % tiling.columns];
    const std::size_t even = count / tiling.columns;
    EXPECT_LT(*std::max_element(per_column.begin(), per_column.end()), 2 * even + 64);
  }
}

/// Tests whether particle p is in the list of `tile` with a slot row range that contains `ray_block`.
class Lists {
 public:
  explicit Lists(const Pass& pass)
      : first_(pass.buffers().binned.first.download()), payload_(pass.buffers().binned.payload.download()) {}
  [[nodiscard]] bool hold(std::uint32_t tile, std::uint32_t particle, std::uint32_t ray_block) const {
    for (std::uint32_t i = first_[tile]; i < first_[tile + 1]; ++i) {
      if ((payload_[i] & SIM_PARTICLE_MASK) != particle) continue;
      return (payload_[i] >> SIM_PARTICLE_BITS & 15U) <= ray_block &&
             payload_[i] >> (SIM_PARTICLE_BITS + 4) >= ray_block;
    }
    return false;
  }

 private:
  std::vector<std::uint32_t> first_, payload_;
};

TEST(LidarTiling, ParticlesOnRaysAreInTheirTiles) {
  const Device& device = test::device();
  for (const std::string& name : builtin_lidar_names()) {
    const Lidar lidar = builtin_lidar(name);
    const LidarRays nominal = nominal_rays(lidar);
    std::vector<std::uint32_t> chosen;
    std::vector<test::SingleParticle> particles;
    for (int row = 0; row < lidar.row_count(); row += std::max(1, lidar.row_count() / 16)) {
      for (const int column : {0, (lidar.columns / 3 + 41 * row) % lidar.columns, lidar.columns - 1}) {
        const auto ray = static_cast<std::uint32_t>(row * lidar.columns + column);
        if (!fires(lidar, ray)) continue;
        const double azimuth = lidar.azimuth(row, column);
        for (const double size : {0.001, 0.1, 1.0, 8.0}) {
          test::SingleParticle particle;
          particle.mean = Eigen::Vector3d(
              lidar.origin(row, azimuth) +
              15.0 * Lidar::direction(azimuth, lidar.rows[static_cast<std::size_t>(row)].elevation));
          particle.scale = Eigen::Vector3d::Constant(size);
          particles.push_back(particle);
          chosen.push_back(ray);
        }
      }
    }
    const ParticleBuffers set(device, test::set_of(SetKind::kLidar, particles), Precision::kFloat);
    const RenderOptions options = paper_options();
    Renderer renderer(device, options);
    const SensorRays rays(device, lidar, nominal, options);
    const Lists lists(renderer.render(set, rays, {}));
    const auto& grid = rays.grid();
    std::vector<std::uint32_t> slot_of_ray(grid.rays);
    for (std::uint32_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
      if (grid.ray_of_slot[slot] >= 0) slot_of_ray[static_cast<std::size_t>(grid.ray_of_slot[slot])] = slot;
    }
    std::size_t missed = 0;
    for (std::uint32_t i = 0; i < chosen.size(); ++i) {
      const std::uint32_t slot = slot_of_ray[chosen[i]];
      missed +=
          lists.hold(slot / grid.frame.tile_rays, i, slot % grid.frame.tile_rays / SIM_RAY_BLOCK) ? 0U : 1U;
    }
    EXPECT_EQ(missed, 0U) << name << ", of " << chosen.size();
    EXPECT_GE(chosen.size(), 64U) << name;
  }
}

}  // namespace lidar_tiling_test
}  // namespace simuli
