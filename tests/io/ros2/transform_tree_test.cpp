#include "io/import/ros2/transform_tree.hpp"

#include <gtest/gtest.h>
#include <string>

#include "host/core/base/linear_algebra.hpp"
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
  tree.add(link("mast", "top", 0, 0.5));  // repeated
  tree.add(link("base_link", "front", 0, 1.5));
  tree.finish();
  EXPECT_NEAR(tree.fixed("base_link", "top")->translation.x(), 2.5, 1e-12);
  EXPECT_NEAR(tree.fixed("front", "top")->translation.x(), 1.0, 1e-12);
  EXPECT_FALSE(tree.fixed("map", "top"));
  std::string world;
  const std::vector<StampedPose> path = tree.path("base_link", world);
  EXPECT_EQ(world, "map");
  ASSERT_EQ(path.size(), 21U);
  EXPECT_NEAR(path[5].pose.translation.x(), 105.5, 1e-12);  // odom moves
  // With several parents the one that leads to the requested root, else the newest.
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

TEST(TransformTree, WorldIsBelowTheCentreOfTheEarth) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  struct Case {
    const char* root;
    Eigen::Vector3d map_m;  // relative to the root
    bool is_level;          // the map's z is the root's, not away from its origin
    const char* world;
  };
  const Case cases[] = {
      {"earth", {4184708.5, 813418.3, 4734575.6}, false, "map"},
      {"FP_ECEF", {-2700000.0, -4292000.0, 3855000.0}, false, "map"},  // California
      {"ecef", {6378137.0, 0.0, 0.0}, false, "map"},                   // the equator
      {"earth", {0.0, 0.0, 6356752.0}, false, "map"},                  // a pole
      {"earth", {-4646000.0, 2553000.0, -3534000.0}, false, "map"},    // Sydney
      {"utm", {448262.0, 6370000.0, 30.0}, true, "utm"},               // equally far, but level
      {"utm", {448262.0, 5412345.0, 310.0}, true, "utm"},
      {"world", {10.0, 5.0, 1.0}, true, "world"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::Message() << c.root << " " << c.map_m.transpose());
    const Eigen::Quaterniond turn = c.is_level ? Eigen::Quaterniond::Identity() : turn_between(up, c.map_m);
    TransformTree tree("a.mcap");
    TransformTree bare("a.mcap");  // the rig is a child of the root
    TransformMessage map;
    map.header.frame_id = c.root;
    map.child_frame_id = "map";
    map.parent_from_child = {turn, c.map_m};
    tree.add(map);
    for (int i = 0; i < 5; ++i) {
      tree.add({{i, "map"}, "base_link", {Eigen::Quaterniond::Identity(), {1.0 * i, 0.0, 0.0}}});
      bare.add({{i, c.root}, "base_link", {turn, c.map_m + Eigen::Vector3d(0.0, 1.0 * i, 0.0)}});
    }
    tree.finish();
    bare.finish();
    std::string world;
    const std::vector<StampedPose> path = tree.path("base_link", world);
    EXPECT_EQ(world, c.world);
    ASSERT_EQ(path.size(), 5U);
    EXPECT_NEAR((path[2].pose.rotation * up).z(), 1.0, 1e-12);
    world = c.root;  // requested: unchanged
    EXPECT_EQ(tree.path("base_link", world).size(), 5U);
    world.clear();
    if (c.is_level)
      EXPECT_EQ(bare.path("base_link", world).size(), 5U);
    else
      expect_input_error([&] { (void)bare.path("base_link", world); }, {c.root, "--world-frame"});
  }
}

}  // namespace
}  // namespace simuli::ros2
