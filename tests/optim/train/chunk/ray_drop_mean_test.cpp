#include <gtest/gtest.h>

#include "optim/train/chunk/chunk_scene.hpp"

namespace simuli {
namespace {

TEST(MeanRayDrop, WeighsStretchesByTheirSweeps) {
  MeanRayDrop sum;
  EXPECT_TRUE(sum.mean().empty());
  const auto add = [&sum](std::size_t sweeps, const char* lidar, double value) {
    ChunkScene part;
    part.report.sweeps = sweeps;
    RayDrop& drop = part.scene.ray_drop.emplace_back(RayDrop{lidar, {}});
    drop.parameters.fill(value);
    sum.add(part);
  };
  add(30, "top", 1.0);
  add(10, "top", 5.0);
  add(10, "low", 7.0);
  const std::vector<RayDrop> mean = sum.mean();
  ASSERT_EQ(mean.size(), 2U);
  EXPECT_EQ(mean[0].lidar, "low");
  EXPECT_EQ(mean[0].parameters.front(), 7.0);
  EXPECT_EQ(mean[1].lidar, "top");
  EXPECT_EQ(mean[1].parameters.back(), 2.0);
}

}  // namespace
}  // namespace simuli
