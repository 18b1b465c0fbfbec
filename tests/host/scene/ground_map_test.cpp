#include "host/core/scene/ground/ground_map.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

namespace simuli {
namespace {

Eigen::Matrix3Xf grid(double first_m,
                      double last_m,
                      double step_m,
                      const std::function<double(double, double)>& z) {
  std::vector<Eigen::Vector3f> all;
  for (double x = first_m; x < last_m; x += step_m) {
    for (double y = first_m; y < last_m; y += step_m)
      all.emplace_back(Eigen::Vector3d(x, y, z(x, y)).cast<float>());
  }
  Eigen::Matrix3Xf out(3, static_cast<Eigen::Index>(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) out.col(static_cast<Eigen::Index>(i)) = all[i];
  return out;
}

TEST(GroundMap, FollowsASlopeBelowWhatStandsOnIt) {
  const auto slope = [](double x, double /*y*/) { return 0.05 * x; };
  GroundMap map;
  for (int sweep = 0; sweep < 10; ++sweep) {
    // A roof of 4 x 4 m always hides the ground below.
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
    map.add(
        grid(-0.9, 0.9, 0.3, [](double x, double) { return -1.0 - x; }));  // the only points in their cells
  }
  map.finish();
  for (double x = -4.0; x < 4.0; x += 0.5) EXPECT_NEAR(*map.height_m(x, 0.0), 0.0, 0.25) << x;
}

TEST(GroundMap, MeshHangsTogetherWithThePath) {
  GroundMap map;
  const auto slope = [](double x, double y) { return 0.05 * x - 0.02 * y; };
  Eigen::Matrix3Xf points = grid(-10.0, 10.0, 0.25, slope);
  // A gap of two by two cells, and a roof without a connection to the ground.
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (points(0, i) > 2.0F && points(0, i) < 4.0F && points(1, i) > 2.0F && points(1, i) < 4.0F)
      points(0, i) += 30.0F;
  }
  map.add(points);
  map.finish();
  const TriangleMesh mesh = map.mesh({{0.0, 0.0}});
  EXPECT_EQ(mesh.vertices.size(), 400U);
  EXPECT_EQ(mesh.triangles.size(), 2U * 19U * 19U);
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices[triangle[0]], b = mesh.vertices[triangle[1]],
                          c = mesh.vertices[triangle[2]];
    EXPECT_GT((b - a).cross(c - a).z(), 0.0F);  // seen from above
  }
  for (const Eigen::Vector3f& v : mesh.vertices)
    EXPECT_NEAR(v.z(), slope(v.x(), v.y()), 0.06) << v.transpose();
  EXPECT_TRUE(map.mesh({{100.0, 100.0}}).vertices.empty());
  GroundMap none;
  none.finish();
  EXPECT_TRUE(none.mesh({{0.0, 0.0}}).triangles.empty());
}

}  // namespace
}  // namespace simuli
