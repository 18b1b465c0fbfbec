#include "host/device/render/scene/tuning.hpp"

#include <gtest/gtest.h>

#include "host/device/render/options/lane_shape.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

TEST(TimeTunings, TriesShapesThenGroupsAndLeavesTheDeviceAsItWas) {
  const Device& device = test::device();
  const DeviceTuning before = tuning_of(device);
  const TuningSearch search = time_tunings(device, 500, 2);
  ASSERT_GE(search.times.size(), 4U);
  EXPECT_EQ(search.times.front().tuning, DeviceTuning{});
  EXPECT_LT(search.best, search.times.size());
  std::size_t shapes = 0, groups = 0;
  for (const TuningTime& time : search.times) {
    EXPECT_GT(time.camera_ms.median, 0.0);
    EXPECT_GT(time.lidar_ms.median, 0.0);
    shapes += time.tuning.lanes != 0 ? 1 : 0;
    groups += time.tuning.group != 0 ? 1 : 0;
    if (time.tuning.lanes != 0) {
      EXPECT_EQ(time.tuning.lanes * time.tuning.vectors * time.tuning.work_items, 256);
    }
  }
  EXPECT_GT(shapes, 0U);
  EXPECT_GT(groups, 0U);
  EXPECT_EQ(tuning_of(device), before);
}

TEST(LaneShape, FollowsTheTuningInFloat) {
  const Device& device = test::device();
  const DeviceTuning before = tuning_of(device);
  set_tuning(device, {.lanes = 8, .vectors = 32, .work_items = 1});
  EXPECT_EQ(lane_shape_of(device, Precision::kFloat).lanes, 8);
  EXPECT_EQ(lane_shape_of(device, Precision::kFloat).vectors, 32);
  EXPECT_EQ(lane_shape_of(device, Precision::kDouble).lanes,
            usual_lane_shape(device, Precision::kDouble).lanes);
  set_tuning(device, before);
}

}  // namespace
}  // namespace simuli
