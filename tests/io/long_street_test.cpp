#include "io/synth/long_street.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

constexpr double kLength_m = 1000.0;
constexpr double kFarAway_m = 1e4;

LongStreetOptions small_options(const std::filesystem::path& output) {
  LongStreetOptions options;
  options.output = output;
  options.length_m = 40.0;
  options.frames = 10;
  options.cameras = 2;
  options.lidars = 2;
  options.image_width = 32;
  options.image_height = 18;
  options.lidar_columns = 24;
  return options;
}

TEST(LongStreet, BendsAndClimbs) {
  const LongStreet street(kLength_m);
  double turned = 0.0, low = 0.0, high = 0.0;
  for (double s = 0.0; s < kLength_m; s += 5.0) {
    const Pose at = street.world_from_street(s, 0.0);
    const Vector3d ahead = at.rotation * Vector3d::UnitX();
    turned = std::max(turned, std::abs(std::atan2(ahead.y(), ahead.x())));
    low = std::min(low, at.translation.z());
    high = std::max(high, at.translation.z());
  }
  EXPECT_GT(turned, 0.3);
  EXPECT_LT(turned, 1.3);  // it does not intersect itself
  EXPECT_GT(high - low, 2.0);
}

TEST(LongStreet, WhatDrivesTurnsAndDoesNotJump) {
  const LongStreet street(kLength_m);
  constexpr double kStep_m = 0.05;
  for (const double left_m : {-1.75, 0.0, 1.75}) {
    Pose before = street.world_from_street(-50.0, left_m);
    for (double s = -50.0 + kStep_m; s < kLength_m + 50.0; s += kStep_m) {
      const Pose at = street.world_from_street(s, left_m);
      const double moved_m = (at.translation - before.translation).norm();
      ASSERT_NEAR(moved_m, kStep_m, 0.1 * kStep_m) << s;
      ASSERT_LT(at.rotation.angularDistance(before.rotation), 0.01 * kStep_m) << s;
      before = at;
    }
  }
}

TEST(LongStreet, TheRoadIsUnderWhatDrives) {
  const LongStreet street(kLength_m);
  constexpr double kAbove_m = 2.5;
  for (double s = -80.0; s < kLength_m + 80.0; s += 1.7) {
    const Pose at = street.world_from_street(s, -1.75);
    const Vector3d up = at.rotation * Vector3d::UnitZ();
    const StreetHit hit = street.trace(at.translation + kAbove_m * up, -up, 0.0, kFarAway_m);
    ASSERT_TRUE(hit.hit) << s;
    ASSERT_NEAR(hit.range, kAbove_m, 0.01) << s;
    ASSERT_GT(hit.normal.dot(up), 0.99) << s;
  }
}

TEST(LongStreet, PiecesMeetWithoutGapsOrSteps) {
  // Down to the road and along both pavements: no surface is below the road or above a tree.
  const LongStreet street(kLength_m);
  constexpr double kAbove_m = 30.0;
  for (const double left_m : {-4.0, 0.0, 4.0}) {
    for (double s = -20.0; s < kLength_m + 20.0; s += 0.25) {
      const Pose at = street.world_from_street(s, left_m);
      const StreetHit hit =
          street.trace(at.translation + Vector3d(0.0, 0.0, kAbove_m), -Vector3d::UnitZ(), 0.0, kFarAway_m);
      ASSERT_TRUE(hit.hit) << s;
      const double height = kAbove_m - hit.range;  // above the road surface
      if (left_m == 0.0) {
        ASSERT_NEAR(height, 0.0, 1e-6) << s;  // no object in the middle of the road
      }
      ASSERT_GT(height, -1e-6) << s;
      ASSERT_LT(height, 8.0) << s;
    }
  }
}

TEST(LongStreet, NoRayLeavesAtEyeHeight) {
  // Walls, cut at the planes between pieces, have no gaps: horizontal rays hit them.
  const LongStreet street(kLength_m);
  std::mt19937 random(3);
  int far = 0;
  constexpr int kRays = 4000;
  for (int i = 0; i < kRays; ++i) {
    const double s = kLength_m * static_cast<double>(random() % 10007) / 10007.0;
    const double angle = 2.0 * 3.14159265358979 * static_cast<double>(random() % 10007) / 10007.0;
    const Pose at = street.world_from_street(s, -1.75);
    const Vector3d direction = at.rotation * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const Vector3d origin = at.translation + at.rotation * Vector3d(0.0, 0.0, 1.5);
    const StreetHit hit = street.trace(origin, direction, 0.0, kFarAway_m);
    far += hit.hit ? 0 : 1;
    if (!hit.hit) continue;
    ASSERT_NEAR(hit.normal.norm(), 1.0, 1e-9);
    ASSERT_LT(hit.normal.dot(direction), 1e-9);
    // No nearer hit exists for any limit, and the limit is respected.
    ASSERT_FALSE(street.trace(origin, direction, 0.0, 0.999 * hit.range).hit);
    ASSERT_EQ(street.trace(origin, direction, 0.0, 1.001 * hit.range).range, hit.range);
  }
  EXPECT_LT(far, kRays / 50);  // through an alley, or over the last hill
}

TEST(LongStreet, PiecesAreMadeWhereRaysComeAndAgainTheSame) {
  LongStreet street(kLength_m);
  EXPECT_EQ(street.pieces_held(), 0U);
  const auto look = [&](double s) {
    const Pose at = street.world_from_street(s, -1.75);
    return street.trace(
        at.translation + Vector3d(0.0, 0.0, 1.5), at.rotation * Vector3d(0.6, 0.8, 0.0), 0.0, 100.0);
  };
  const StreetHit first = look(100.0);
  ASSERT_TRUE(first.hit);
  EXPECT_LT(street.pieces_held(), 8U);
  std::size_t most = 0;
  for (double s = 0.0; s < kLength_m; s += 7.0) {
    static_cast<void>(look(s));
    street.forget_beyond(s, 100.0);
    most = std::max(most, street.pieces_held());
  }
  EXPECT_LE(most, 11U);
  EXPECT_GT(street.pieces(), 60U);
  const StreetHit again = look(100.0);
  EXPECT_EQ(again.range, first.range);
  EXPECT_EQ(again.colour, first.colour);
}

TEST(LongStreet, TrafficIsWhereItsTracksAre) {
  LongStreetOptions options = small_options("unused");
  options.length_m = 600.0;
  options.frames = 600;
  const Log log = long_street_log(options);
  ASSERT_GT(log.actors.size(), 5U);
  LongStreet street(options.length_m);
  street.set_traffic(log.actors);
  int seen = 0;
  for (const Actor& car : log.actors) {
    validate(car, "traffic");
    for (const KeyPose& key : car.track) {
      const double time_s = key.time_s + 0.03;
      if (!car.is_there(time_s)) continue;
      const Pose at = car.at(time_s);
      // From 6 m above its centre down: its roof, and beside it the road.
      const Vector3d up = at.rotation * Vector3d::UnitZ(), left = at.rotation * Vector3d::UnitY();
      const StreetHit roof = street.trace(at.translation + 6.0 * up, -up, time_s, kFarAway_m);
      ASSERT_TRUE(roof.on_car) << car.name << " " << time_s;
      ASSERT_NEAR(roof.range, 6.0 - 0.5 * car.size_m.z(), 1e-6);
      ASSERT_FALSE(street.trace(at.translation + 6.0 * up + left, -up, time_s, kFarAway_m).on_car);
      ++seen;
    }
  }
  EXPECT_GT(seen, 1000);
  // Cars do not intersect the rig or each other.
  for (double time_s = 0.0; time_s < 60.0; time_s += 0.5) {
    std::vector<Vector3d> places{log.world_from_rig.at(time_s).translation};
    for (const Actor& car : log.actors) {
      if (car.is_there(time_s)) places.push_back(car.at(time_s).translation);
    }
    for (std::size_t a = 0; a < places.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) ASSERT_GT((places[a] - places[b]).norm(), 2.5) << time_s;
    }
  }
}

TEST(LongStreet, BecomesALogWhateverTheThreads) {
  const test::Scratch scratch;
  LongStreetOptions options = small_options(scratch / "a.log");
  options.threads = 1;
  const Log log = synth_long_street(options);
  EXPECT_EQ(log.cameras.size(), 2U);
  EXPECT_EQ(log.lidars.size(), 2U);
  EXPECT_EQ(log.images.size(), 20U);
  EXPECT_EQ(log.sweeps.size(), 20U);
  EXPECT_NEAR(log.world_from_rig.at(1.0).translation.x(), 40.0, 0.5);
  options.output = scratch / "b.log";
  options.threads = 2;
  const Log other = synth_long_street(options);
  EXPECT_EQ(log_hash(log), log_hash(other));
  for (std::size_t i = 0; i < log.images.size(); ++i) {
    EXPECT_EQ(read_file(log.folder / log.images[i].file), read_file(other.folder / other.images[i].file));
  }
  const Sweep sweep = read_sweep(log.folder / log.sweeps[0].file, log.lidars[0].model);
  EXPECT_GT(std::count_if(sweep.range.begin(), sweep.range.end(), [](float r) { return r > 0.0F; }), 100);
}

TEST(LongStreet, OptionsOutOfRangeAreRefused) {
  const auto refused = [](const auto& change, const std::string& part) {
    LongStreetOptions options = small_options("unused");
    change(options);
    expect_error(ErrorKind::kUsage, part, [&] { static_cast<void>(long_street_log(options)); });
  };
  refused([](auto& o) { o.length_m = 5.0; }, "--length: found ");
  refused([](auto& o) { o.length_m = std::nan(""); }, "--length: found ");
  refused([](auto& o) { o.length_m = 600.0; }, "at most 50");
  refused([](auto& o) { o.frames = 0; }, "--frames: found 0, allowed 1 to 1000000");
  refused([](auto& o) { o.cameras = 5; }, "--cameras");
  refused([](auto& o) { o.cameras = 0; }, "--cameras");
  refused([](auto& o) { o.lidars = 4; }, "--lidars");
}

}  // namespace
}  // namespace simuli
