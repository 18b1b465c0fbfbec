// Range pictures by azimuth, whatever rows fire at once.
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "host/apps/cli/draw/pictures.hpp"
#include "host/apps/cli/draw/sweep_canvas.hpp"

namespace simuli::cli {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr int kColumns = 36;
constexpr std::array<float, 3> kBlack{0.0F, 0.0F, 0.0F};

/// Rows of which each fires by so many columns further along the spin.
Lidar lidar_of(const std::vector<int>& shifts, SpinDirection spin, double span_rad = kTurn_rad) {
  Lidar lidar;
  lidar.columns = kColumns;
  lidar.azimuth_first = 0.3;
  lidar.azimuth_span = span_rad;
  lidar.spin = spin;
  lidar.range_min = 1.0;
  lidar.range_max = 100.0;
  for (const int shift : shifts) {
    LidarRow row;
    row.elevation = -0.01 * static_cast<double>(lidar.rows.size());
    row.azimuth_offset = lidar.spin_sign() * shift * span_rad / kColumns;
    lidar.rows.push_back(row);
  }
  return lidar;
}

/// A world whose distance is told by the azimuth alone, another one every column.
std::vector<float> ranges_of(const Lidar& lidar, const LidarRays& rays) {
  std::vector<float> range;
  for (const float azimuth : rays.azimuth) {
    const double columns = lidar.spin_sign() * (static_cast<double>(azimuth) - lidar.azimuth_first) *
                           kColumns / lidar.azimuth_span;
    const bool is_turn = lidar.azimuth_span > 6.0;
    const long column = std::lround(columns);
    range.push_back(2.0F +
                    static_cast<float>(is_turn ? (column % kColumns + kColumns) % kColumns : column + 10));
  }
  return range;
}

std::array<float, 3> colour(const Image& image, int x, int row) {
  return {image.at(x, row * SweepCanvas::kBeam_px, 0),
          image.at(x, row * SweepCanvas::kBeam_px, 1),
          image.at(x, row * SweepCanvas::kBeam_px, 2)};
}

class RangeImage : public testing::TestWithParam<SpinDirection> {};

TEST_P(RangeImage, IsTheSameInEveryRowOfAWholeTurn) {
  const Lidar lidar = lidar_of({9, 3, -3, -9, 0, 40}, GetParam());
  const LidarRays rays = nominal_rays(lidar);
  const Image image = range_image(lidar, rays, ranges_of(lidar, rays));
  const Lidar plain = lidar_of({0}, GetParam());
  const LidarRays plain_rays = nominal_rays(plain);
  const Image expected = range_image(plain, plain_rays, ranges_of(plain, plain_rays));
  ASSERT_EQ(image.width, kColumns);
  ASSERT_EQ(image.height, 6 * SweepCanvas::kBeam_px);
  for (int x = 0; x < kColumns; ++x) {
    if (x > 0) {
      EXPECT_NE(colour(expected, x, 0), colour(expected, x - 1, 0));
    }
    for (int row = 0; row < 6; ++row)
      EXPECT_EQ(colour(image, x, row), colour(expected, x, 0)) << x << ' ' << row;
  }
}

TEST_P(RangeImage, WidensColumnsForRowsInBetween) {
  // A row 2.5 columns behind the first one: its rays stand half a column beside the others'.
  Lidar lidar = lidar_of({0, 0}, GetParam());
  lidar.rows[1].azimuth_offset = lidar.spin_sign() * -2.5 * kTurn_rad / kColumns;
  const LidarRays rays = nominal_rays(lidar);
  std::vector<float> range(rays.azimuth.size(), 0.0F);
  range[10] = range[kColumns + 12] = 5.0F;
  const Image image = range_image(lidar, rays, range);
  ASSERT_EQ(image.width, 2 * kColumns);
  ASSERT_EQ(image.height, 2 * 2 * SweepCanvas::kBeam_px);
  const int left = GetParam() == SpinDirection::kClockwise ? 20 : 2 * (kColumns - 11);
  const int towards = GetParam() == SpinDirection::kClockwise ? -1 : 1;
  for (int x = 0; x < image.width; ++x) {
    EXPECT_EQ(colour(image, x, 0) != kBlack, x == left || x == left + 1) << x;
    EXPECT_EQ(colour(image, x, 2) != kBlack, x == left + towards || x == left + 1 + towards) << x;
  }
}

TEST_P(RangeImage, TellsWhereAPartOfATurnHasNoRay) {
  const Lidar lidar = lidar_of({2, 0, -1}, GetParam(), 1.0);
  const LidarRays rays = nominal_rays(lidar);
  const Image image = range_image(lidar, rays, ranges_of(lidar, rays));
  ASSERT_EQ(image.width, kColumns + 3);
  const auto at = [&](int along, int row) {
    return colour(image, GetParam() == SpinDirection::kClockwise ? along : image.width - 1 - along, row);
  };
  for (int along = 0; along < image.width; ++along) {
    EXPECT_EQ(at(along, 0) == SweepCanvas::kNoRay, along < 3);
    EXPECT_EQ(at(along, 1) == SweepCanvas::kNoRay, along < 1 || along >= kColumns + 1);
    EXPECT_EQ(at(along, 2) == SweepCanvas::kNoRay, along >= kColumns);
    if (along >= 3 && along < kColumns) {
      EXPECT_EQ(at(along, 0), at(along, 1));
      EXPECT_EQ(at(along, 0), at(along, 2));
    }
  }
}

TEST_P(RangeImage, FollowsRaysAsTheyWereFired) {
  // Rows that the model knows nothing of, and rays that are not quite where they should be.
  const Lidar fired = lidar_of({5, 0, -7}, GetParam()), known = lidar_of({0, 0, 0}, GetParam());
  LidarRays rays = nominal_rays(fired);
  const std::vector<float> range = ranges_of(fired, rays);
  for (std::size_t i = 0; i < rays.azimuth.size(); ++i) rays.azimuth[i] += i % 2 == 0 ? 0.05F : -0.05F;
  const Image image = range_image(known, rays, range);
  for (int x = 0; x < kColumns; ++x) {
    EXPECT_EQ(colour(image, x, 0), colour(image, x, 1));
    EXPECT_EQ(colour(image, x, 0), colour(image, x, 2));
  }
}

TEST_P(RangeImage, TellsNoReturnFromNoWayOut) {
  Lidar lidar = lidar_of({0, 4}, GetParam());
  const LidarRays rays = nominal_rays(lidar);
  lidar.blind = {{.row = 1, .azimuth_first = 1.0, .azimuth_last = 2.0}};
  const Image image = range_image(lidar, rays, std::vector<float>(rays.azimuth.size(), 0.0F));
  int blind = 0;
  for (int x = 0; x < kColumns; ++x) {
    EXPECT_EQ(colour(image, x, 0), kBlack);
    blind += colour(image, x, 1) == SweepCanvas::kNoRay ? 1 : 0;
    EXPECT_TRUE(colour(image, x, 1) == SweepCanvas::kNoRay || colour(image, x, 1) == kBlack);
  }
  EXPECT_NEAR(blind, kColumns / kTurn_rad, 1.0);
}

INSTANTIATE_TEST_SUITE_P(BothWays,
                         RangeImage,
                         testing::Values(SpinDirection::kClockwise, SpinDirection::kCounterClockwise),
                         [](const auto& spin) {
                           return spin.param == SpinDirection::kClockwise ? "Clockwise" : "CounterClockwise";
                         });

TEST(RangeErrorImage, TellsErrorsFromDrops) {
  const Lidar lidar = lidar_of({0}, SpinDirection::kClockwise);
  const LidarRays rays = nominal_rays(lidar);
  std::vector<float> range(kColumns, 8.0F), truth(kColumns, 8.0F);
  range[1] = 8.25F;
  range[2] = 7.75F;
  range[3] = 0.0F;
  truth[4] = 0.0F;
  range[5] = truth[5] = 0.0F;
  range[6] = 20.0F;
  const Image image = range_error_image(lidar, rays, range, truth);
  EXPECT_EQ(colour(image, 0, 0), kBlack);
  EXPECT_EQ(colour(image, 1, 0), error_colour(0.25F));
  EXPECT_EQ(colour(image, 2, 0), colour(image, 1, 0));
  EXPECT_GT(colour(image, 3, 0)[2], 0.9F);
  EXPECT_GT(colour(image, 4, 0)[1], 2.0F * colour(image, 4, 0)[2]);
  EXPECT_EQ(colour(image, 5, 0), kBlack);
  EXPECT_EQ(colour(image, 6, 0), error_colour(1.0F));
}

TEST(RangeImageOfAList, ShowsWhereRaysAre) {
  const LidarRays rays{.rows = 1,
                       .columns = 3,
                       .azimuth = {0.2F, 0.0F, -0.2F},
                       .elevation = {0.1F, 0.0F, -0.1F},
                       .time_fraction = {0.0F, 0.0F, 0.0F}};
  RayList model;
  model.range_min = 1.0;
  model.range_max = 100.0;
  const Image image = range_image(model, rays, {5.0F, 0.0F, 5.0F});
  const auto at = [&](int x, int y) {
    return std::array<float, 3>{image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
  };
  EXPECT_NE(at(0, 0), SweepCanvas::kNoRay);
  EXPECT_NE(at(0, 0), kBlack);
  EXPECT_EQ(at(0, 0), at(image.width - 1, image.height - 1));
  EXPECT_EQ(at((image.width - 2) / 2, (image.height - 2) / 2), kBlack);
  EXPECT_EQ(at(image.width - 1, 0), SweepCanvas::kNoRay);
}

}  // namespace
}  // namespace simuli::cli
