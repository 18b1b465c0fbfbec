#include "io/import/ros2/transform_tree.hpp"

#include <gtest/gtest.h>
#include <string>

#include "tests/io/scratch.hpp"

namespace simuli::ros2 {
namespace {

using test::expect_input_error;

TEST(TransformTree, FixedAndMovingLinks) {
  const auto link = [](const char* parent, const char* child, std::int64_t ns, double x) {
    return TransformMessage{{ns, parent}, child, {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}};
  };
  TransformTree tree("a.mcap");
  for (int i = 0; i < 3; ++i) tree.add(link("map", "odom", 10 * i, 100.0 + i));
  for (int i = 0; i < 21; ++i) tree.add(link("odom", "base_link", i, 1.0 * i));
  tree.add(link("base_link", "mast", 0, 2.0));
  tree.add(link("mast", "top", 5, 0.5));
  tree.add(link("mast", "top", 0, 0.5));  // told twice
  tree.add(link("base_link", "front", 0, 1.5));
  tree.finish();
  EXPECT_NEAR(tree.fixed("base_link", "top")->translation.x(), 2.5, 1e-12);
  EXPECT_NEAR(tree.fixed("front", "top")->translation.x(), 1.0, 1e-12);
  EXPECT_FALSE(tree.fixed("map", "top"));
  std::string world;
  const std::vector<StampedPose> path = tree.path("base_link", world);
  EXPECT_EQ(world, "map");
  ASSERT_EQ(path.size(), 21U);
  EXPECT_NEAR(path[5].pose.translation.x(), 105.5, 1e-12);  // odom itself moves
  // Of several parents the one that leads to where it is asked for, else the newest.
  tree.add(link("utm", "base_link", 3, 7.0));
  tree.add(link("camera", "tag", 0, 1.0));
  tree.add(link("other_camera", "tag", 1, 1.0));
  tree.finish();
  EXPECT_EQ(tree.ambiguous(), (std::vector<std::string>{"base_link", "tag"}));
  EXPECT_NEAR(tree.fixed("base_link", "top")->translation.x(), 2.5, 1e-12);
  world = "utm";
  EXPECT_EQ(tree.path("base_link", world).size(), 0U);
  world = "map";
  EXPECT_EQ(tree.path("base_link", world).size(), 21U);
  EXPECT_TRUE(tree.fixed("camera", "tag"));
  EXPECT_TRUE(tree.fixed("other_camera", "tag"));
  TransformTree circle("a.mcap");
  circle.add(link("a", "b", 0, 0.0));
  circle.add(link("b", "a", 0, 0.0));
  circle.finish();
  expect_input_error([&] { (void)circle.fixed("c", "b"); }, {"frame b", "in itself"});
}

}  // namespace
}  // namespace simuli::ros2
