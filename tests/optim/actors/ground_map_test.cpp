#include "optim/actors/ground_map.hpp"

#include <gtest/gtest.h>

namespace simuli {
namespace {

PointSet grid(double first_m, double last_m, double step_m, const std::function<double(double, double)>& z) {
  std::vector<Eigen::Vector3f> all;
  for (double x = first_m; x < last_m; x += step_m) {
    for (double y = first_m; y < last_m; y += step_m)
      all.emplace_back(Eigen::Vector3d(x, y, z(x, y)).cast<float>());
  }
  PointSet out;
  out.position.resize(3, static_cast<Eigen::Index>(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) out.position.col(static_cast<Eigen::Index>(i)) = all[i];
  out.intensity.assign(all.size(), 0.5F);
  return out;
}

TEST(GroundMap, FollowsASlopeBelowWhatStandsOnIt) {
  const auto slope = [](double x, double /*y*/) { return 0.05 * x; };
  GroundMap map;
  for (int sweep = 0; sweep < 10; ++sweep) {
    // A roof of 4 x 4 m hides the ground below it, always.
    map.add(grid(-10.0, 10.0, 0.25, [&](double x, double y) {
      return slope(x, y) + (std::abs(x) < 2.0 && std::abs(y) < 2.0 ? 1.5 : 0.0);
    }));
  }
  map.finish();
  for (double x = -8.0; x < 8.0; x += 0.7) {
    const auto height = map.height_m(x, 0.3);
    ASSERT_TRUE(height.has_value()) << x;
    const double reached_m = std::abs(x) < 3.0 ? 0.35 : 0.06;  // from the rim, as steep as the map allows
    EXPECT_NEAR(*height, slope(x, 0.3), reached_m) << x;
  }
  EXPECT_FALSE(map.height_m(30.0, 0.0).has_value());
}

TEST(GroundMap, MirrorImagesBelowARoadDoNotLowerIt) {
  GroundMap map;
  for (int sweep = 0; sweep < 10; ++sweep) {
    map.add(grid(-6.0, 6.0, 0.25, [](double, double) { return 0.0; }));
    map.add(grid(-0.9, 0.9, 0.3, [](double x, double) { return -1.0 - x; }));  // seen alone in its cells
  }
  map.finish();
  for (double x = -4.0; x < 4.0; x += 0.5) EXPECT_NEAR(*map.height_m(x, 0.0), 0.0, 0.25) << x;
}

}  // namespace
}  // namespace simuli
