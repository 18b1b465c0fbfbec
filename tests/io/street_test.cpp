#include "io/synth/street.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "host/core/base/error.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/io/scratch.hpp"
#include "tests/support/street_rays.hpp"

namespace simuli {
namespace street_test {

using Eigen::Vector3d;

// A few rounding errors of double at 10 m.
constexpr double kExact_m = 1e-12;
// Ranges are stored as float: half a unit in the last place at 100 m is 4e-6 m; the rest is a margin for
// times rounded to nanoseconds (1e-8 m at 10 m/s).
constexpr double kStoredRange_m = 1e-4;
constexpr double kFarAway_m = 1e4;

StreetOptions small_options(const std::filesystem::path& output) {
  StreetOptions options;
  options.output = output;
  options.frames = 2;
  options.image_width = 48;
  options.image_height = 27;
  options.lidar_columns = 120;
  return options;
}

TEST(Street, IsAsItAlwaysWas) {
  const Street street;
  double range = 0.0, reflectance = 0.0;
  Vector3d colour = Vector3d::Zero(), normal = Vector3d::Zero();
  constexpr int kRays = 20000;
  for (int i = 0; i < kRays; ++i) {
    const test::StreetRay ray = test::ray_of(i);
    const StreetHit hit = street.trace(ray.origin, ray.direction, 0.7, kFarAway_m);
    range += hit.range;
    reflectance += hit.reflectance;
    colour += hit.colour;
    normal += hit.normal.cwiseAbs();
  }
  // Rounding of sines differs between libraries.
  constexpr double kSame = 1e-7;
  EXPECT_NEAR(range / kRays, 11.555953322941, kSame);
  EXPECT_NEAR(reflectance / kRays, 0.285933484373, kSame);
  EXPECT_NEAR(colour.x() / kRays, 0.393244908632, kSame);
  EXPECT_NEAR(colour.z() / kRays, 0.374211104225, kSame);
  EXPECT_NEAR(normal.x() / kRays, 0.095978750156, kSame);
}

TEST(Street, RoadLiesAtZeroAndPavementAKerbHigher) {
  const Street street;
  const StreetHit road = street.trace({10.0, -1.0, 2.0}, -Vector3d::UnitZ(), 0.0, kFarAway_m);
  ASSERT_TRUE(road.hit);
  EXPECT_NEAR(road.range, 2.0, kExact_m);
  EXPECT_EQ(road.normal, Vector3d::UnitZ());
  const StreetHit pavement = street.trace({10.0, -5.6, 2.0}, -Vector3d::UnitZ(), 0.0, kFarAway_m);
  EXPECT_NEAR(pavement.range, 1.85, kExact_m);
  // 3-4-5: 1.5 m down along a slope of 3 in 5, under the trees and between the parked cars.
  const StreetHit slope = street.trace({0.0, 0.0, 1.5}, {0.8, 0.0, -0.6}, -1e3, kFarAway_m);
  EXPECT_NEAR(slope.range, 2.5, kExact_m);
}

TEST(Street, SkyAndRangeLimit) {
  const Street street;
  EXPECT_FALSE(street.trace({0.0, 0.0, 2.0}, Vector3d::UnitZ(), 0.0, kFarAway_m).hit);
  EXPECT_FALSE(street.trace({0.0, 0.0, 2.0}, -Vector3d::UnitZ(), 0.0, 1.9).hit);
  EXPECT_TRUE(street.trace({0.0, 0.0, 2.0}, -Vector3d::UnitZ(), 0.0, 2.1).hit);
  const StreetHit sky = street.trace({0.0, 0.0, 2.0}, Vector3d::UnitZ(), 0.0, kFarAway_m);
  EXPECT_GT(sky.colour.z(), sky.colour.x());  // blue
}

TEST(Street, RaysThatAreNoRaysHitNothing) {
  const Street street;
  const double nan = std::nan("");
  EXPECT_FALSE(street.trace({nan, 0.0, 2.0}, -Vector3d::UnitZ(), 0.0, kFarAway_m).hit);
  EXPECT_FALSE(street.trace({0.0, 0.0, 2.0}, {0.0, nan, -1.0}, 0.0, kFarAway_m).hit);
  EXPECT_FALSE(street.trace({0.0, 0.0, 2.0}, -Vector3d::UnitZ(), nan, kFarAway_m).hit);
  EXPECT_FALSE(street.trace({0.0, 0.0, 2.0}, -Vector3d::UnitZ(), 0.0, nan).hit);
}

TEST(Street, CarMovesAtItsSpeed) {
  const Street street;
  constexpr double kRear_m = 2.1;  // from the car's middle to its bumper
  for (const double time_s : {0.0, 0.5, 1.234, 2.0}) {
    const double x = StreetCar{}.position(time_s).x();
    EXPECT_NEAR(x, StreetCar{}.position(0.0).x() + StreetCar{}.speed_m_per_s * time_s, kExact_m);
    const StreetHit rear = street.trace({0.0, 1.75, 0.6}, Vector3d::UnitX(), time_s, kFarAway_m);
    ASSERT_TRUE(rear.hit);
    EXPECT_TRUE(rear.on_car);
    EXPECT_NEAR(rear.range, x - kRear_m, kExact_m);
    EXPECT_EQ(rear.normal, -Vector3d::UnitX());
  }
}

TEST(Street, CarCanBeLeftOut) {
  const Street street({.car = std::nullopt});
  const StreetHit hit = street.trace({0.0, 1.75, 0.6}, Vector3d::UnitX(), 0.0, kFarAway_m);
  ASSERT_TRUE(hit.hit);  // the houses across the end
  EXPECT_FALSE(hit.on_car);
  EXPECT_GT(hit.range, Street::kLength_m);
}

TEST(Street, ThinPolesStandBeforeWhatIsThereAnyway) {
  const Street without({.car = std::nullopt}), with({.car = std::nullopt, .thin_poles = true});
  std::size_t on_pole = 0;
  for (int i = 0; i < 20000; ++i) {  // a row of rays across the street along the pavement's edge
    const Vector3d origin(0.005 * i, 0.0, 1.0);
    const StreetHit bare = without.trace(origin, Vector3d::UnitY(), 0.0, kFarAway_m);
    const StreetHit hit = with.trace(origin, Vector3d::UnitY(), 0.0, kFarAway_m);
    if (hit.range == bare.range) continue;
    ++on_pole;
    EXPECT_TRUE(!bare.hit || hit.range < bare.range);
    EXPECT_NEAR(hit.range, 5.7, 0.02);
  }
  // One pole per 3 m with a mean width of 2.8 cm, unless it is occluded.
  EXPECT_GT(on_pole, 80U);
  EXPECT_LT(on_pole, 280U);
}

TEST(Street, CarPaintTravelsWithTheCar) {
  const Street street;
  const auto side = [&](double time_s) {
    const Vector3d origin = StreetCar{}.position(time_s) + Vector3d(-1.7, -1.2, 0.7);
    return street.trace(origin, Vector3d::UnitY(), time_s, kFarAway_m);
  };
  ASSERT_TRUE(side(0.0).on_car);
  EXPECT_TRUE(side(0.0).colour.isApprox(side(1.7).colour));
}

TEST(Street, LidarIsBlindToGlassAndToFaintReturns) {
  const Street street;
  // The rear window of the moving car is glass, its tail is painted.
  const Vector3d behind = StreetCar{}.position(0.0) - Vector3d(6.0, 0.0, 0.0);
  const Vector3d window = behind + Vector3d(0.0, 0.0, 1.2);
  ASSERT_TRUE(street.trace(window, Vector3d::UnitX(), 0.0, 100.0).on_car);
  EXPECT_EQ(street.lidar_return(window, Vector3d::UnitX(), 0.0, 0.9, 100.0).range, 0.0);
  const StreetReturn tail =
      street.lidar_return(behind + Vector3d(0.0, 0.0, 0.7), Vector3d::UnitX(), 0.0, 0.9, 100.0);
  EXPECT_NEAR(tail.range, 6.0 - 2.1, kExact_m);
  EXPECT_GT(tail.intensity, 0.0);
  EXPECT_LE(tail.intensity, 1.0);
  // Asphalt at a grazing angle: a return at 15 m, none at 60 m, but still in the picture.
  const auto road = [&](double distance_m) {
    const Vector3d direction = Vector3d(-distance_m, 0.0, -1.9).normalized();
    EXPECT_TRUE(street.trace({100.0, -1.0, 1.9}, direction, 0.0, 100.0).hit);
    return street.lidar_return({100.0, -1.0, 1.9}, direction, 0.0, 0.9, 100.0).range;
  };
  EXPECT_NEAR(road(15.0), std::hypot(15.0, 1.9), 1e-9);
  EXPECT_EQ(road(60.0), 0.0);
  // Below the minimum range.
  EXPECT_EQ(street.lidar_return({0.0, 0.0, 0.5}, -Vector3d::UnitZ(), 0.0, 0.9, 100.0).range, 0.0);
}

TEST(Street, AShiftedRigPassesTheSameStreet) {
  StreetOptions options = small_options("unused");
  const Log log = street_log(options);
  options.lane_shift_m = 3.0;
  const Log shifted = street_log(options);
  for (const double time_s : {0.0, 0.13, 0.2}) {
    const Pose here = log.world_from_rig.at(time_s);
    const Pose there = shifted.world_from_rig.at(time_s);
    EXPECT_NEAR((here * Vector3d(0.0, 3.0, 0.0) - there.translation).norm(), 0.0, kExact_m);
    EXPECT_NEAR(here.rotation.angularDistance(there.rotation), 0.0, kExact_m);
  }
  EXPECT_EQ(shifted.actors.front().track.front().world_from_actor.translation,
            log.actors.front().track.front().world_from_actor.translation);
  options.lane_shift_m = 4.5;
  EXPECT_THROW((void)street_log(options), Error);
  options.lane_shift_m = std::nan("");
  EXPECT_THROW((void)street_log(options), Error);
}

TEST(Street, SweepIsTracedFromEachRaysOwnOriginAtItsOwnTime) {
  StreetOptions options = small_options("unused");
  options.lidar_columns = 300;
  const Log log = street_log(options);
  const Street street;
  const LogLidar& lidar = log.lidars.front();
  const Lidar& model = lidar.with_rows();
  const SweepFrame& frame = log.sweeps[1];
  const Sweep sweep = scan_street(street, lidar, log.world_from_rig, frame.time_start_s, frame.time_end_s);
  int returns = 0;
  int drops = 0;
  double static_error_m = 0.0;  // error without motion compensation within the sweep
  for (int r = 0; r < model.row_count(); ++r) {
    const LidarRow& row = model.rows[static_cast<std::size_t>(r)];
    for (int c = 0; c < model.columns; ++c) {
      const auto i = static_cast<std::size_t>(r * model.columns + c);
      const double az = static_cast<double>(sweep.rays.azimuth[i]);
      const double el = static_cast<double>(sweep.rays.elevation[i]);
      const double time_s = frame.time_start_s + 0.1 * static_cast<double>(sweep.rays.time_fraction[i]);
      const Vector3d origin(-row.horizontal_offset * std::sin(az),
                            row.horizontal_offset * std::cos(az),
                            row.vertical_offset + 1.9);
      const Vector3d direction(std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), std::sin(el));
      const auto trace_at = [&](double pose_time_s) {
        const Pose world_from_rig = log.world_from_rig.at(pose_time_s);
        return street.trace(world_from_rig * origin, world_from_rig.rotation * direction, time_s, 100.0);
      };
      const auto range = static_cast<double>(sweep.range[i]);
      if (range == 0.0) {
        ++drops;
        EXPECT_EQ(sweep.intensity[i], 0.0F);
        continue;
      }
      ++returns;
      EXPECT_NEAR(range, trace_at(time_s).range, kStoredRange_m) << "row " << r << " column " << c;
      static_error_m = std::max(static_error_m, std::abs(range - trace_at(frame.time_start_s).range));
    }
  }
  EXPECT_GT(returns, 20 * drops / 10);  // glass and dark asphalt: some drops, far fewer than returns
  EXPECT_GT(drops, returns / 50);
  EXPECT_GT(static_error_m, 0.1);  // the sweep takes 0.8 m of motion: the test detects missing compensation
}

TEST(Street, PicturesDependOnSeedAndTimeButNotOnThreads) {
  StreetOptions options = small_options("unused");
  const Log log = street_log(options);
  const auto picture = [&](const Street& street, double time_s, int threads) {
    return render_street(street, log.cameras.front(), log.world_from_rig, time_s, time_s, threads).data;
  };
  const Street street;
  const std::vector<float> once = picture(street, 0.05, 1);
  EXPECT_EQ(once, picture(Street(), 0.05, 7));
  EXPECT_NE(once, picture(Street({.seed = 2}), 0.05, 1));
  EXPECT_NE(once, picture(street, 0.15, 1));
  EXPECT_TRUE(std::all_of(once.begin(), once.end(), [](float v) { return v >= 0.0F && v <= 1.0F; }));
  const auto sweep = [&](int threads) {
    return scan_street(street, log.lidars.front(), log.world_from_rig, 0.0, 0.1, threads);
  };
  EXPECT_EQ(sweep(1).range, sweep(5).range);
  EXPECT_EQ(sweep(1).intensity, sweep(5).intensity);
}

TEST(Street, PictureShowsTheMovingCarWhereItIs) {
  const Log log = street_log(small_options("unused"));
  const LogCamera& camera = log.cameras.front();
  const double time_s = 0.05;
  const Pose world_from_camera = log.world_from_rig.at(time_s) * camera.rig_from_camera;
  const Vector3d tail = StreetCar{}.position(time_s) + Vector3d(-2.1, 0.4, 0.7);
  Eigen::Vector2d pixel;
  ASSERT_TRUE(camera.model.project(world_from_camera.inverse() * tail, pixel));
  const auto x = static_cast<int>(pixel.x());
  const auto y = static_cast<int>(pixel.y());
  const Image with = render_street(Street(), camera, log.world_from_rig, time_s, time_s);
  const Image without =
      render_street(Street({.car = std::nullopt}), camera, log.world_from_rig, time_s, time_s);
  EXPECT_GT(with.at(x, y, 0), with.at(x, y, 2) + 0.3F);        // yellow paint
  EXPECT_LT(without.at(x, y, 0), without.at(x, y, 2) + 0.1F);  // grey road
}

TEST(Street, PersonWalksInTheirBox) {
  const StreetWalker walker;
  const Street with({.car = std::nullopt, .walker = walker}), without({.car = std::nullopt});
  const Actor actor = walker.actor(0.0, 2.0);
  std::set<int> seen_cm;  // positions of the foremost point of the feet
  for (double time_s = 0.0; time_s <= 2.0; time_s += 0.05) {
    const Pose world_from_actor = actor.at(time_s);
    const Vector3d half = 0.5 * actor.size_m;
    int met = 0;
    double foremost = -1.0;
    for (double y = -1.0; y <= 1.0; y += 0.04) {
      for (double z = -0.9; z <= 1.0; z += 0.04) {
        // From the front of the person, and from the side.
        for (const bool beside : {false, true}) {
          const Vector3d from = beside ? Vector3d(y, 3.0, z) : Vector3d(3.0, y, z);
          const Vector3d to = world_from_actor.rotation * (beside ? -Vector3d::UnitY() : -Vector3d::UnitX());
          const Vector3d origin = world_from_actor * from;
          const StreetHit hit = with.trace(origin, to, time_s, 5.0);
          const StreetHit behind = without.trace(origin, to, time_s, 5.0);
          if (hit.range == behind.range && hit.hit == behind.hit) continue;
          ++met;
          const Vector3d p = world_from_actor.inverse() * Vector3d(origin + hit.range * to);
          EXPECT_LE(std::abs(p.x()), half.x());
          EXPECT_LE(std::abs(p.y()), half.y());
          EXPECT_LE(std::abs(p.z()), half.z());
          EXPECT_NEAR(hit.normal.norm(), 1.0, 1e-9);
          EXPECT_LT(hit.normal.dot(to), 1e-9);  // 0 at a grazing angle
          if (p.z() < -0.5) foremost = std::max(foremost, p.x());
        }
      }
    }
    EXPECT_GT(met, 100);
    seen_cm.insert(static_cast<int>(100.0 * foremost));
  }
  EXPECT_GT(*seen_cm.rbegin() - *seen_cm.begin(), 15);  // legs swing
}

TEST(Street, RollingShutterReadsTopToBottom) {
  StreetOptions options = small_options("unused");
  options.rolling_shutter = true;
  const Log log = street_log(options);
  const ImageFrame& frame = log.images.front();
  EXPECT_NEAR(frame.time_end_s - frame.time_start_s, 0.02, 1e-12);
  const Street street;
  const auto rows_like = [&](const Image& picture, double time_s) {
    const Image still = render_street(street, log.cameras.front(), log.world_from_rig, time_s, time_s);
    double top = 0.0;
    double bottom = 0.0;
    for (int x = 0; x < picture.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        top += std::abs(picture.at(x, 0, c) - still.at(x, 0, c));
        bottom += std::abs(picture.at(x, picture.height - 1, c) - still.at(x, picture.height - 1, c));
      }
    }
    return std::pair{top, bottom};
  };
  const Image rolling =
      render_street(street, log.cameras.front(), log.world_from_rig, frame.time_start_s, frame.time_end_s);
  const auto [top_at_start, bottom_at_start] = rows_like(rolling, frame.time_start_s);
  const auto [top_at_end, bottom_at_end] = rows_like(rolling, frame.time_end_s);
  EXPECT_LT(top_at_start, top_at_end);
  EXPECT_LT(bottom_at_end, bottom_at_start);
}

TEST(Street, LogIsReadBackAsWritten) {
  const test::Scratch scratch;
  const StreetOptions options = small_options(scratch / "street");
  std::size_t calls = 0;
  const Log written = synth_street(options, [&](std::size_t done, std::size_t total) {
    EXPECT_EQ(done, ++calls);
    EXPECT_EQ(total, 2U);
  });
  EXPECT_EQ(calls, 2U);
  EXPECT_EQ(written.folder, options.output);
  const Log log = read_log(options.output);
  EXPECT_EQ(log_hash(written), log_hash(log));  // so that eval can identify the training frames of a scene
  ASSERT_EQ(log.images.size(), 2U);
  ASSERT_EQ(log.sweeps.size(), 2U);
  const Street street({.seed = options.seed});
  const SweepFrame& frame = log.sweeps[1];
  EXPECT_NEAR(frame.time_start_s, 0.1, 1e-9);
  const LogLidar& lidar = log.lidar(frame.lidar);
  const Sweep stored = read_sweep(log.folder / frame.file, lidar.model);
  const Sweep truth = scan_street(street, lidar, log.world_from_rig, frame.time_start_s, frame.time_end_s);
  ASSERT_EQ(stored.range.size(), ray_count(lidar.model));
  // Drops are equal except for rays at an edge: times in nanoseconds move the sensor by 1e-9 m.
  std::size_t different_drops = 0;
  for (std::size_t i = 0; i < stored.range.size(); ++i) {
    if ((stored.range[i] > 0.0F) != (truth.range[i] > 0.0F)) {
      ++different_drops;
    } else {
      EXPECT_NEAR(stored.range[i], truth.range[i], kStoredRange_m);
    }
    EXPECT_EQ(stored.rays.azimuth[i], truth.rays.azimuth[i]);
    EXPECT_EQ(stored.rays.time_fraction[i], truth.rays.time_fraction[i]);
  }
  EXPECT_LE(different_drops, 1U);
  const ImageFrame& image = log.images[1];
  EXPECT_NEAR(image.time_start_s, 0.15, 1e-9);
  const Image picture = read_image(log.folder / image.file);
  const Image drawn = render_street(
      street, log.camera(image.camera), log.world_from_rig, image.time_start_s, image.time_end_s);
  ASSERT_EQ(picture.data.size(), drawn.data.size());
  constexpr double kEightBits = 0.5 / 255.0 + 1e-4;  // rounding to 8 bits
  for (std::size_t i = 0; i < drawn.data.size(); ++i) EXPECT_NEAR(picture.data[i], drawn.data[i], kEightBits);
}

TEST(Street, OutputIsCompleteOrNotThere) {
  const test::Scratch scratch;
  StreetOptions options = small_options(scratch / "street");
  EXPECT_THROW(synth_street(options, [](std::size_t, std::size_t) { throw std::runtime_error("stop"); }),
               std::runtime_error);
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
  (void)synth_street(options);
  test::expect_input_error([&] { (void)synth_street(options); }, {"street", "allowed"});
}

TEST(Street, OptionsOutsideTheirRangeAreRefused) {
  const auto refused = [](const char* field, const auto& change) {
    StreetOptions options = small_options("unused");
    change(options);
    expect_error(ErrorKind::kUsage, field, [&] { (void)street_log(options); });
  };
  refused("--frames: found 0, allowed 1 to 10000", [](StreetOptions& o) { o.frames = 0; });
  refused("--speed: found", [](StreetOptions& o) { o.speed_m_per_s = std::nan(""); });
  refused("--image-width", [](StreetOptions& o) { o.image_width = 1 << 30; });
  refused("--image-height", [](StreetOptions& o) { o.image_height = -1; });
  refused("--lidar-columns", [](StreetOptions& o) { o.lidar_columns = 0; });
  refused("260 m", [](StreetOptions& o) { o.frames = 1000; });
}

}  // namespace street_test
}  // namespace simuli
