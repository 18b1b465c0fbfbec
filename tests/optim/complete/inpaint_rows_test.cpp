#include "optim/complete/inpaint_rows.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace simuli {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

/// Returns one row of rays with these ranges; the first feature of ray i is i.
RayRows row_of(const std::vector<float>& range_m, std::size_t first, std::size_t end) {
  RayRows rows;
  rows.rows = 1;
  rows.columns = range_m.size();
  rows.range_m = range_m;
  rows.actor.assign(range_m.size(), 0);
  for (std::size_t i = first; i < end; ++i) rows.actor[i] = 7;
  for (std::size_t i = 0; i < range_m.size(); ++i)
    rows.features.push_back({static_cast<float>(i), 0.0F, 0.5F});
  return rows;
}

TEST(InpaintRows, APlaneGoesOnBetweenTwoSides) {
  // 1 / range of a plane is linear along the row.
  std::vector<float> range_m;
  for (int i = 0; i < 20; ++i) range_m.push_back(1.0F / (0.1F + 0.001F * static_cast<float>(i)));
  RayRows rows = row_of(range_m, 6, 15);
  for (std::size_t i = 6; i < 15; ++i) rows.range_m[i] = 0.0F;
  const std::vector<FilledRay> filled = inpaint_rows(rows);
  ASSERT_EQ(filled.size(), 9U);
  for (const FilledRay& ray : filled) {
    // The sides are means of three rays, whose centres are one ray beside the gap's ends.
    EXPECT_NEAR(ray.range_m, range_m[ray.ray], 0.01F * range_m[ray.ray]) << ray.ray;
    EXPECT_NEAR(ray.features[0], static_cast<float>(ray.ray), 1.5F);
    EXPECT_FLOAT_EQ(ray.features[2], 0.5F);
  }
}

TEST(InpaintRows, WhatIsKnownBehindActorsStays) {
  RayRows rows = row_of({5, 5, 5, 0, 5, 5, 5, 5}, 2, 6);
  const std::vector<FilledRay> filled = inpaint_rows(rows);
  ASSERT_EQ(filled.size(), 1U);
  EXPECT_EQ(filled[0].ray, 3U);
  EXPECT_FLOAT_EQ(filled[0].range_m, 5.0F);
}

TEST(InpaintRows, TheFartherSideGoesOnBehindTheNearerOne) {
  const RayRows rows = row_of({4, 4, 4, 0, 0, 0, 0, 30, 30, 30}, 3, 7);
  for (const FilledRay& ray : inpaint_rows(rows)) EXPECT_FLOAT_EQ(ray.range_m, 30.0F);
  EXPECT_EQ(inpaint_rows(rows).size(), 4U);
}

TEST(InpaintRows, WhatIsThinBesideAGapDoesNotGoOn) {
  // A pole, as wide as an edge, is in front of the wall on the left.
  RayRows rows = row_of({20, 20, 20, 20, 4, 4, 4, 0, 0, 20, 20, 20}, 7, 9);
  rows.around = 3;
  for (const FilledRay& ray : inpaint_rows(rows)) EXPECT_FLOAT_EQ(ray.range_m, 20.0F);
  rows = row_of({20, 20, 20, 20, 4, 4, 4, 0, 0}, 7, 9);
  rows.around = 1;  // only as far as the pole
  for (const FilledRay& ray : inpaint_rows(rows)) EXPECT_FLOAT_EQ(ray.range_m, 4.0F);
  rows.around = 6;
  ASSERT_EQ(inpaint_rows(rows).size(), 2U);
  for (const FilledRay& ray : inpaint_rows(rows)) EXPECT_FLOAT_EQ(ray.range_m, 20.0F);
}

TEST(InpaintRows, TheSkyStaysOpen) {
  EXPECT_TRUE(inpaint_rows(row_of({0, 0, 0, 0, 0, 0}, 2, 4)).empty());
  EXPECT_TRUE(inpaint_rows(row_of({kFar, kFar, kFar, 0, 0, kFar, kFar, kFar}, 3, 5)).empty());
  // Next to the sky half of the gap continues the other side; at the end of the picture the complete gap
  // does.
  const std::vector<FilledRay> half = inpaint_rows(row_of({9, 9, 9, 0, 0, 0, 0, kFar, kFar}, 3, 7));
  ASSERT_EQ(half.size(), 2U);
  EXPECT_EQ(half[0].ray, 3U);
  EXPECT_EQ(half[1].ray, 4U);
  EXPECT_EQ(inpaint_rows(row_of({9, 9, 9, 0, 0, 0, 0}, 3, 7)).size(), 4U);
  EXPECT_EQ(inpaint_rows(row_of({0, 0, 0, 0, 9, 9, 9}, 0, 4)).size(), 4U);
}

TEST(InpaintRows, AClosedRowHasOneGapAcrossItsEnds) {
  RayRows rows = row_of({0, 0, 6, 6, 6, 6, 6, 6, 0, 0}, 8, 10);
  rows.actor[0] = rows.actor[1] = 7;
  rows.closed = true;
  const std::vector<FilledRay> filled = inpaint_rows(rows);
  ASSERT_EQ(filled.size(), 4U);
  EXPECT_EQ(filled[0].ray, 8U);
  EXPECT_EQ(filled[2].ray, 0U);
  for (const FilledRay& ray : filled) EXPECT_FLOAT_EQ(ray.range_m, 6.0F);
  // Completely hidden: no result.
  rows.actor.assign(10, 7);
  rows.range_m.assign(10, 0.0F);
  EXPECT_TRUE(inpaint_rows(rows).empty());
}

TEST(InpaintRows, RowsStandForThemselves) {
  RayRows rows = row_of({3, 3, 3, 0, 8, 8, 8, 0}, 0, 0);
  rows.rows = 2;
  rows.columns = 4;
  rows.actor = {0, 0, 0, 7, 0, 0, 0, 7};
  const std::vector<FilledRay> filled = inpaint_rows(rows);
  ASSERT_EQ(filled.size(), 2U);
  EXPECT_FLOAT_EQ(filled[0].range_m, 3.0F);
  EXPECT_FLOAT_EQ(filled[1].range_m, 8.0F);
}

TEST(WidenActors, ByRowsAndColumnsAndAroundAClosedRow) {
  RayRows rows = row_of(std::vector<float>(20, 1.0F), 0, 1);
  rows.rows = 4;
  rows.columns = 5;
  rows.closed = true;
  rows.actor[7] = 3;  // row 1, column 2
  widen_actors(rows, 1);
  const std::vector<std::uint32_t> expected = {7, 7, 3, 3, 7,  //
                                               7, 7, 3, 3, 7,  //
                                               0, 3, 3, 3, 0,  //
                                               0, 0, 0, 0, 0};
  EXPECT_EQ(rows.actor, expected);
}

}  // namespace
}  // namespace simuli
