#include "host/core/sensors/lidar.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "host/core/base/angles.hpp"
#include "tests/host/expect_error.hpp"

namespace simuli {
namespace lidar_test {

constexpr double kRounding = 1e-12;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Lidar two_rows(SpinDirection spin) {
  Lidar lidar;
  lidar.name = "two";
  lidar.rows = {{0.1, 0.02, 0.2, 0.05, 3e-6}, {-0.1, -0.02, 0.1, -0.05, 0.0}};
  lidar.columns = 4;
  lidar.azimuth_first = 0.5;
  lidar.azimuth_span = 2.0 * kPi;
  lidar.spin = spin;
  lidar.range_min = 0.5;
  lidar.range_max = 100.0;
  return lidar;
}

TEST(Lidar, AzimuthRunsWithTheSpin) {
  const Lidar left = two_rows(SpinDirection::kCounterClockwise);
  const Lidar right = two_rows(SpinDirection::kClockwise);
  for (int c = 0; c < 4; ++c) {
    EXPECT_NEAR(left.azimuth(0, c), 0.5 + c * kPi / 2 + 0.02, kRounding);
    EXPECT_NEAR(right.azimuth(0, c), 0.5 - c * kPi / 2 + 0.02, kRounding);
    EXPECT_NEAR(right.azimuth(1, c), 0.5 - c * kPi / 2 - 0.02, kRounding);
  }
}

TEST(Lidar, TimeRunsForwardInEitherSpin) {
  for (const SpinDirection spin : {SpinDirection::kCounterClockwise, SpinDirection::kClockwise}) {
    const Lidar lidar = two_rows(spin);
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(lidar.time_fraction(1, c), (c + 0.5) / 4, kRounding);
    EXPECT_NEAR(lidar.time_fraction(0, 1), 0.375 + 3e-5, kRounding);  // 3 us of 0.1 s
  }
}

TEST(Lidar, DirectionsFollowTheFrame) {
  EXPECT_LT((Lidar::direction(0, 0) - Eigen::Vector3d(1, 0, 0)).norm(), kRounding);
  EXPECT_LT((Lidar::direction(kPi / 2, 0) - Eigen::Vector3d(0, 1, 0)).norm(), kRounding);
  EXPECT_LT((Lidar::direction(1.0, kPi / 2) - Eigen::Vector3d(0, 0, 1)).norm(), kRounding);
  const Eigen::Vector3d d = Lidar::direction(2.1, -0.3);
  EXPECT_NEAR(d.norm(), 1.0, kRounding);
  EXPECT_NEAR(std::atan2(d.y(), d.x()), 2.1, kRounding);
  EXPECT_NEAR(std::atan2(d.z(), std::hypot(d.x(), d.y())), -0.3, kRounding);
}

TEST(Lidar, OriginStandsToTheLeftOfTheBeamAndUp) {
  const Lidar lidar = two_rows(SpinDirection::kClockwise);
  EXPECT_LT((lidar.origin(0, 0.0) - Eigen::Vector3d(0, 0.05, 0.2)).norm(), kRounding);
  EXPECT_LT((lidar.origin(0, kPi / 2) - Eigen::Vector3d(-0.05, 0, 0.2)).norm(), kRounding);
  EXPECT_LT((lidar.origin(1, 0.0) - Eigen::Vector3d(0, -0.05, 0.1)).norm(), kRounding);
  // The offset is across the beam, not along it.
  const double azimuth = 1.234;
  const Eigen::Vector3d across = lidar.origin(0, azimuth) - Eigen::Vector3d(0, 0, 0.2);
  EXPECT_NEAR(across.dot(Lidar::direction(azimuth, 0)), 0.0, kRounding);
}

TEST(Lidar, RadialOffsetMovesTheOriginAlongTheBeam) {
  Lidar lidar = two_rows(SpinDirection::kClockwise);
  lidar.rows[0].radial_offset = 0.03;
  const double azimuth = 1.234;
  const Eigen::Vector3d moved =
      lidar.origin(0, azimuth) - two_rows(SpinDirection::kClockwise).origin(0, azimuth);
  EXPECT_LT((moved - 0.03 * Lidar::direction(azimuth, 0.0)).norm(), kRounding);
}

TEST(Lidar, NominalRaysAreRowMajorAndWrapped) {
  const Lidar lidar = two_rows(SpinDirection::kCounterClockwise);
  const LidarRays rays = nominal_rays(lidar);
  EXPECT_EQ(rays.rows, 2);
  EXPECT_EQ(rays.columns, 4);
  ASSERT_EQ(rays.azimuth.size(), lidar.ray_count());
  ASSERT_EQ(rays.elevation.size(), lidar.ray_count());
  ASSERT_EQ(rays.time_fraction.size(), lidar.ray_count());
  for (int r = 0; r < 2; ++r) {
    for (int c = 0; c < 4; ++c) {
      const auto i = static_cast<std::size_t>(4 * r + c);
      const double turns = (lidar.azimuth(r, c) - static_cast<double>(rays.azimuth[i])) / (2 * kPi);
      EXPECT_NEAR(turns, std::round(turns), 1e-6);  // float angles
      EXPECT_LE(std::abs(rays.azimuth[i]), static_cast<float>(kPi));
      EXPECT_FLOAT_EQ(rays.elevation[i], r == 0 ? 0.1F : -0.1F);
      EXPECT_FLOAT_EQ(rays.time_fraction[i], static_cast<float>(lidar.time_fraction(r, c)));
    }
  }
}

TEST(Lidar, ValidateNamesTheFieldThatIsWrong) {
  EXPECT_NO_THROW(validate(two_rows(SpinDirection::kClockwise), "log.json"));
  const auto refused = [](const char* field, auto set) {
    Lidar lidar = two_rows(SpinDirection::kClockwise);
    set(lidar);
    expect_error(ErrorKind::kInput, std::string("log.json: lidar two: ") + field, [&] {
      validate(lidar, "log.json");
    });
  };
  refused("rows: found 0", [](Lidar& l) { l.rows.clear(); });
  refused("rows: found 4097", [](Lidar& l) { l.rows.resize(4097); });
  refused("columns", [](Lidar& l) { l.columns = 0; });
  refused("columns", [](Lidar& l) { l.columns = (1 << 20) + 1; });
  refused("rows[1].elevation_rad", [](Lidar& l) { l.rows[1].elevation = 0.2; });  // not top to bottom
  refused("rows[0].elevation_rad", [](Lidar& l) { l.rows[0].elevation = kNan; });
  refused("rows[0].elevation_rad", [](Lidar& l) { l.rows[0].elevation = 1.6; });
  refused("rows[1].azimuth_offset_rad", [](Lidar& l) { l.rows[1].azimuth_offset = kNan; });
  refused("rows[0].vertical_offset_m", [](Lidar& l) { l.rows[0].vertical_offset = 11.0; });
  refused("rows[0].horizontal_offset_m", [](Lidar& l) { l.rows[0].horizontal_offset = kNan; });
  refused("rows[0].range_bias_m", [](Lidar& l) { l.rows[0].range_bias = 1.5; });
  refused("rows[0].radial_offset_m", [](Lidar& l) { l.rows[0].radial_offset = -10.5; });
  refused("rows[0].time_offset_s", [](Lidar& l) { l.rows[0].time_offset = 2.0; });
  refused("azimuth_first_rad", [](Lidar& l) { l.azimuth_first = kNan; });
  refused("azimuth_span_rad", [](Lidar& l) { l.azimuth_span = 0.0; });
  refused("azimuth_span_rad", [](Lidar& l) { l.azimuth_span = 6.3; });
  refused("range_min_m", [](Lidar& l) { l.range_min = -1.0; });
  refused("range_max_m", [](Lidar& l) { l.range_max = 0.5; });
  refused("range_max_m", [](Lidar& l) { l.range_max = std::numeric_limits<double>::infinity(); });
  refused("beam_divergence_rad", [](Lidar& l) { l.beam_divergence = kNan; });
  refused("divergence_variance", [](Lidar& l) { l.divergence_variance = -0.1; });
  refused("rows[1].fires_every", [](Lidar& l) { l.rows[1].every = 0; });
  refused("rows[0].fires_first", [](Lidar& l) { l.rows[0].first = 1; });
  refused("blind_arcs[0].row", [](Lidar& l) { l.blind = {{2, 0.0, 1.0}}; });
  refused("blind_arcs[1].row", [](Lidar& l) { l.blind = {{1, 0.0, 1.0}, {0, 0.0, 1.0}}; });
  refused("blind_arcs[0].azimuth_first_rad", [](Lidar& l) { l.blind = {{0, -0.1, 1.0}}; });
  refused("blind_arcs[1].azimuth_first_rad", [](Lidar& l) { l.blind = {{0, 0.0, 1.0}, {0, 0.5, 2.0}}; });
  refused("blind_arcs[0].azimuth_last_rad", [](Lidar& l) { l.blind = {{0, 0.0, 6.3}}; });
  refused("blind_arcs[0].azimuth_last_rad", [](Lidar& l) { l.blind = {{0, 0.0, kNan}}; });
}

TEST(Lidar, BlindArcsHoldTheirRaysOnAnyTurn) {
  Lidar lidar = two_rows(SpinDirection::kClockwise);
  const auto is_blind_in = [&](int row, double azimuth) {
    return is_blind(lidar, static_cast<std::size_t>(row * lidar.columns), azimuth);
  };
  EXPECT_FALSE(is_blind_in(0, 1.0));
  lidar.blind = {{0, 0.5, 1.0}, {0, 6.0, 2.0 * kPi}, {1, 0.0, 0.25}};
  for (const double turn : {-2.0 * kPi, 0.0, 4.0 * kPi}) {
    EXPECT_FALSE(is_blind_in(0, turn + 0.49));
    EXPECT_TRUE(is_blind_in(0, turn + 0.51));
    EXPECT_TRUE(is_blind_in(0, turn + 0.99));
    EXPECT_FALSE(is_blind_in(0, turn + 1.01));
    EXPECT_FALSE(is_blind_in(0, turn + 0.1));  // row 1's arc
    EXPECT_TRUE(is_blind_in(1, turn + 0.1));
    EXPECT_FALSE(is_blind_in(1, turn + 0.75));
    EXPECT_TRUE(is_blind_in(0, turn - 0.1));  // the last arc ends at the full turn
    EXPECT_FALSE(is_blind_in(1, turn - 0.1));
  }
}

TEST(Lidar, RowsFireInTheirColumns) {
  Lidar lidar = two_rows(SpinDirection::kClockwise);
  EXPECT_FALSE(lidar.has_blind());
  lidar.rows[1].every = 2;
  lidar.rows[1].first = 1;
  EXPECT_TRUE(lidar.has_blind());
  EXPECT_EQ(firings_of(lidar, 0), lidar.columns);
  EXPECT_EQ(firings_of(lidar, 1), lidar.columns / 2);
  int fired = 0;
  for (int c = 0; c < lidar.columns; ++c) {
    EXPECT_FALSE(is_blind(lidar, static_cast<std::size_t>(c), 0.0));
    const auto ray = static_cast<std::size_t>(lidar.columns + c);
    EXPECT_EQ(is_blind(lidar, ray, 0.0), c % 2 == 0);
    fired += fires(lidar, ray) ? 1 : 0;
  }
  EXPECT_EQ(fired, firings_of(lidar, 1));
}

TEST(Lidar, KittiTableCrossesTheSpinAxisWhereItWasFitted) {
  const Lidar lidar = builtin_lidar("kitti_hdl64e");
  ASSERT_EQ(lidar.row_count(), 64);
  // z = tan(v) rho + Vo / cos(v): the line fit of the first ring, at the height of the spin axis.
  EXPECT_NEAR(lidar.rows[0].vertical_offset, 0.20900 / std::cos(0.033801667), kRounding);
  EXPECT_EQ(lidar.spin, SpinDirection::kClockwise);
  EXPECT_GT(lidar.rows[31].vertical_offset - lidar.rows[32].vertical_offset, 0.07);  // two laser blocks
  // A clockwise sweep that starts at the rear passes the front at half time.
  EXPECT_NEAR(std::remainder(lidar.azimuth(0, lidar.columns / 2), 2 * kPi), 0.0, lidar.azimuth_span / 2156);
}

}  // namespace lidar_test
}  // namespace simuli
