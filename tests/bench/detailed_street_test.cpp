// The detailed street.
#include "bench/street/detailed_street.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "bench/street/detail.hpp"
#include "io/synth/street.hpp"
#include "io/synth/street_world.hpp"
#include "tests/io/scratch.hpp"
#include "tests/support/street_rays.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;

constexpr double kFar_m = 1e4;

TEST(DetailedStreet, PicturesAndSweepsAreTheSameAgainAndByAnyThreads) {
  const Street street({.detail = &detailed_street()}), again({.detail = &detailed_street()}),
      other({.seed = 2, .detail = &detailed_street()});
  const Log log = street_log({.output = {}, .image_width = 64, .image_height = 36, .lidar_columns = 120});
  const auto picture = [&](const Street& of, int threads) {
    return render_street(of, log.cameras.front(), log.world_from_rig, 0.05, 0.05, threads).data;
  };
  const std::vector<float> once = picture(street, 1);
  EXPECT_EQ(once, picture(again, 5));
  EXPECT_NE(once, picture(other, 2));
  EXPECT_NE(once, picture(Street(), 2));
  EXPECT_TRUE(std::all_of(once.begin(), once.end(), [](float v) { return v >= 0.0F && v <= 1.0F; }));
  const auto sweep = [&](const Street& of, int threads) {
    return scan_street(of, log.lidars.front(), log.world_from_rig, 0.0, 0.1, threads);
  };
  EXPECT_EQ(sweep(street, 1).range, sweep(again, 5).range);
  EXPECT_EQ(sweep(street, 1).intensity, sweep(again, 5).intensity);
}

TEST(DetailedStreet, IndexFindsWhatTestingEverySolidFinds) {
  const StreetWorld world = build_street_world({.detail = &detailed_street()});
  EXPECT_GT(world.solids.size(), 5000U);
  int met = 0;
  for (int i = 0; i < 1500; ++i) {
    test::StreetRay ray = test::ray_of(i);
    if (i % 10 == 0) ray.direction = Vector3d::Unit(i / 10 % 3) * (i % 20 == 0 ? 1.0 : -1.0);
    const Vector3d inverse = ray.direction.cwiseInverse();
    StreetCrossing all{200.0, Vector3d::Zero()}, found = all;
    for (const StreetSolid& solid : world.solids) {
      (void)solid.shape(solid, ray.origin, ray.direction, inverse, all);
    }
    const StreetSolid* solid = world.index.meet(world.solids, ray.origin, ray.direction, inverse, found);
    EXPECT_EQ(found.range, all.range) << i;
    EXPECT_EQ(solid != nullptr, all.range < 200.0);
    met += solid != nullptr ? 1 : 0;
  }
  EXPECT_GT(met, 1000);
}

TEST(DetailedStreet, SolidsLieWithinTheirBounds) {
  const StreetWorld world = build_street_world({.detail = &detailed_street()});
  for (std::size_t i = 0; i < world.solids.size(); ++i) {
    const StreetSolid& solid = world.solids[i];
    ASSERT_TRUE((solid.low.array() <= solid.high.array()).all());
    // Rays at its middle from six sides, and what they meet.
    const Vector3d middle = 0.5 * (solid.low + solid.high);
    for (int side = 0; side < 6; ++side) {
      const Vector3d towards =
          Vector3d::Unit(side / 2) * (side % 2 == 0 ? 1.0 : -1.0) + Vector3d(0.01, 0.02, 0.005);
      const Vector3d direction = towards.normalized(), origin = middle - 300.0 * direction;
      StreetCrossing at;
      if (!solid.shape(solid, origin, direction, direction.cwiseInverse(), at)) continue;
      const Vector3d point = origin + at.range * direction;
      ASSERT_TRUE((point.array() >= solid.low.array() - 1e-6).all()) << i;
      ASSERT_TRUE((point.array() <= solid.high.array() + 1e-6).all()) << i;
      ASSERT_NEAR(at.normal.norm(), 1.0, 1e-9) << i;
      ASSERT_LE(at.normal.dot(direction), 1e-9) << i;
    }
  }
}

/// What a ray meets, another from elsewhere meets, too, or something before it.
TEST(DetailedStreet, EveryEyeMeetsTheSameSurfaces) {
  const Street street({.car = std::nullopt, .detail = &detailed_street()});
  const Log log = street_log({});
  int open = 0, same_range = 0;
  for (int i = 0; i < 20000; ++i) {
    const test::StreetRay ray = test::ray_of(i);
    const StreetHit hit = street.trace(ray.origin, ray.direction, 0.0, 90.0);
    if (!hit.hit) continue;
    ASSERT_NEAR(hit.normal.norm(), 1.0, 1e-9);
    ASSERT_LE(hit.normal.dot(ray.direction), 1e-9);
    ASSERT_TRUE(hit.colour.minCoeff() >= 0.0 && hit.colour.maxCoeff() <= 1.0);
    ASSERT_TRUE(hit.reflectance >= 0.0 && hit.reflectance <= 1.0);
    const Vector3d point = ray.origin + hit.range * ray.direction;
    const Vector3d eye = ray.origin + Vector3d(0.6, -0.3, 0.35), way = point - eye;
    const double distance = way.norm();
    if (!(hit.normal.dot(way) < -0.05 * distance)) continue;  // its other side
    const StreetHit seen = street.trace(eye, way / distance, 0.0, kFar_m);
    ASSERT_TRUE(seen.hit) << i;
    ASSERT_LE(seen.range, distance + 1e-6) << i;
    ++open;
    if (seen.range < distance - 1e-6) continue;
    ++same_range;
    const StreetReturn back = street.lidar_return(eye, way / distance, 0.0, 0.1, 200.0);
    if (back.range > 0.0) {
      ASSERT_NEAR(back.range, distance, 1e-6);
    }
  }
  EXPECT_GT(open, 8000);
  EXPECT_GT(same_range, open * 3 / 4);
}

TEST(DetailedStreet, NothingStandsWhereTheRigDrivesOrIsMovedTo) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Street street({.seed = seed, .car = std::nullopt, .detail = &detailed_street()});
    // Its lane, 3 m to the left, its sway and half its width; up to the LiDAR above its roof.
    for (double y = -1.75 - 0.3 - 0.95; y <= -1.75 + 3.0 + 0.3 + 0.95; y += 0.05) {
      for (double z = 0.25; z <= 2.1; z += 0.05) {
        const StreetHit hit = street.trace({-5.0, y, z}, Vector3d::UnitX(), 0.0, kFar_m);
        ASSERT_GT(hit.range, Street::kLength_m) << "seed " << seed << ", y " << y << ", z " << z;
      }
    }
    // Nor lies anything on the road there.
    for (double x = 0.0; x < Street::kLength_m; x += 0.5) {
      for (double y = -3.0; y <= 2.5; y += 0.1) {
        const StreetHit hit = street.trace({x, y, 2.1}, -Vector3d::UnitZ(), 0.0, kFar_m);
        ASSERT_NEAR(hit.range, 2.1, 1e-9) << "seed " << seed << ", x " << x << ", y " << y;
      }
    }
  }
}

/// Of neighbours' differences: their mean square, and the share of those that an eye sees.
std::pair<double, double> gradients(const Image& picture) {
  constexpr double kSeen = 0.03;
  double sum = 0.0, seen = 0.0;
  for (int y = 0; y + 1 < picture.height; ++y) {
    for (int x = 0; x + 1 < picture.width; ++x) {
      double square = 0.0;
      for (int c = 0; c < 3; ++c) {
        const auto at = static_cast<double>(picture.at(x, y, c));
        square += std::pow(static_cast<double>(picture.at(x + 1, y, c)) - at, 2) +
                  std::pow(static_cast<double>(picture.at(x, y + 1, c)) - at, 2);
      }
      sum += square / 3.0;
      seen += square / 3.0 > kSeen * kSeen ? 1.0 : 0.0;
    }
  }
  return {sum / (picture.width * picture.height), seen / (picture.width * picture.height)};
}

TEST(DetailedStreet, PicturesShowMore) {
  const Street plain, detailed({.detail = &detailed_street()});
  const Log log = street_log({.output = {}, .image_width = 320, .image_height = 180});
  for (const double time_s : {0.1, 0.9, 1.7}) {
    const auto gradients_of = [&](const Street& street) {
      return gradients(render_street(street, log.cameras.front(), log.world_from_rig, time_s, time_s));
    };
    const auto [energy, seen] = gradients_of(detailed);
    const auto [plain_energy, plain_seen] = gradients_of(plain);
    EXPECT_GT(energy, 1.35 * plain_energy) << time_s;
    EXPECT_GT(seen, 1.8 * plain_seen) << time_s;
  }
}

TEST(DetailedStreet, LidarMeetsThinThings) {
  const StreetWorld world = build_street_world({.detail = &detailed_street()});
  const Log log = street_log({});
  const LogLidar& lidar = log.lidars.front();
  const Sweep sweep =
      scan_street(Street({.detail = &detailed_street()}), lidar, log.world_from_rig, 0.5, 0.6);
  int thin = 0, leaves = 0;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (sweep.range[i] == 0.0F) continue;
    const double time_s = 0.5 + 0.1 * static_cast<double>(sweep.rays.time_fraction[i]);
    const Pose world_from_lidar = log.world_from_rig.at(time_s) * lidar.rig_from_lidar;
    const Vector3d direction =
        (world_from_lidar.rotation * Lidar::direction(static_cast<double>(sweep.rays.azimuth[i]),
                                                      static_cast<double>(sweep.rays.elevation[i])))
            .normalized();
    StreetCrossing at;
    const StreetSolid* solid = world.index.meet(world.solids,
                                                world_from_lidar * ray_origin(lidar.model, sweep.rays, i),
                                                direction,
                                                direction.cwiseInverse(),
                                                at);
    if (solid == nullptr || std::abs(at.range - static_cast<double>(sweep.range[i])) > 1e-3) continue;
    const bool is_long = solid->shape == meet_pole || solid->shape == bench::meet_rod;
    thin += is_long && solid->radius < 0.04 ? 1 : 0;
    leaves += solid->material == StreetMaterial::kLeaves ? 1 : 0;
  }
  EXPECT_GT(thin, 100);
  EXPECT_GT(leaves, 300);
}

/// Patterns finer than a pixel end as their mean, not as noise of the rays.
TEST(DetailedStreet, WhatPixelsCannotTellApartIsEven) {
  const StreetWorld world = build_street_world({.detail = &detailed_street()});
  int walls = 0;
  for (const StreetSolid& house : world.solids) {
    constexpr std::uint32_t kBrick = 1;
    if (house.material != StreetMaterial::kFacade || (house.style - 1) % 8 != kBrick || house.low.y() > 0.0)
      continue;
    const auto at = [&](double footprint_m) {
      double sum = 0.0, change = 0.0, last = 0.0;
      constexpr int kSteps = 400;
      for (int i = 0; i < kSteps; ++i) {  // up a pier, between windows
        const Vector3d point(house.low.x() + 0.08, house.high.y(), 1.9 + 0.004 * i);
        const double red =
            world.detail->surface(house, point, Vector3d::UnitY(), world.seed, footprint_m).albedo.x();
        sum += red;
        change += i == 0 ? 0.0 : std::abs(red - last);
        last = red;
      }
      return std::pair{sum / kSteps, change};
    };
    const auto [near_mean, near_change] = at(0.005);
    const auto [far_mean, far_change] = at(0.5);
    EXPECT_GT(near_change, 4.0 * far_change);
    EXPECT_NEAR(near_mean, far_mean, 0.06 * far_mean);
    ++walls;
  }
  EXPECT_GT(walls, 3);
}

TEST(DetailedStreet, ItsLogIsThatOfThePlainStreetButForWhatIsSeen) {
  const test::Scratch scratch;
  StreetOptions options;
  options.output = scratch / "detailed";
  options.frames = 1;
  options.image_width = 48;
  options.image_height = 27;
  options.lidar_columns = 60;
  options.detail = &detailed_street();
  const Log log = synth_street(options);
  const Image picture = read_image(log.folder / log.images.front().file);
  const ImageFrame& image = log.images.front();
  const Image truth = render_street(Street(options.contents()),
                                    log.camera("front"),
                                    log.world_from_rig,
                                    image.time_start_s,
                                    image.time_end_s);
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    ASSERT_NEAR(picture.data[i], truth.data[i], 0.5 / 255.0 + 1e-4);
  }
  options.detail = nullptr;
  options.output = scratch / "plain";
  const Log plain = synth_street(options);
  EXPECT_NE(read_image(plain.folder / image.file).data, picture.data);
  EXPECT_EQ(plain.world_from_rig.poses().back().pose.translation,
            log.world_from_rig.poses().back().pose.translation);
  EXPECT_EQ(plain.actors.size(), log.actors.size());
}

}  // namespace
}  // namespace simuli::bench
