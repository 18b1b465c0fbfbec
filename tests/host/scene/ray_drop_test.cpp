#include "host/core/scene/ray_drop.hpp"

#include <gtest/gtest.h>

#include "cl/shared/sensor_constants.h"

namespace simuli {
namespace {

TEST(RayDrop, IsOfTheSensorOfThatNameElseOfTheFirst) {
  RayDrop::Parameters mine = RayDrop::start(), other = RayDrop::start();
  mine[4] = 0.25;
  other[4] = -0.5;
  const std::vector<RayDrop> all{{"front", other}, {"top", mine}};
  EXPECT_EQ(ray_drop_of(all, "top"), mine);
  EXPECT_EQ(ray_drop_of(all, "front"), other);
  EXPECT_EQ(ray_drop_of(all, "hesai_pandar64"), other);
  EXPECT_EQ(ray_drop_of({}, "top"), RayDrop::of_logits());
}

TEST(RayDrop, StartsAsTheLogitsWithHiddenSumsThatDiffer) {
  const auto start = shared::from_reals<shared::DropConstants>(RayDrop::start());
  const auto logits = shared::from_reals<shared::DropConstants>(RayDrop::of_logits());
  for (int j = 0; j < SIM_DROP_INPUTS; ++j) EXPECT_EQ(start.skip[j], logits.skip[j]);
  EXPECT_EQ(start.bias, 0.0);
  for (int k = 0; k < SIM_DROP_HIDDEN; ++k) {
    EXPECT_EQ(start.out[k], 0.0);
    for (int other = 0; other < k; ++other) {
      EXPECT_NE(start.hidden[k * (SIM_DROP_INPUTS + 1)], start.hidden[other * (SIM_DROP_INPUTS + 1)]);
    }
  }
  for (const double weight : logits.hidden) EXPECT_EQ(weight, 0.0);
}

}  // namespace
}  // namespace simuli
