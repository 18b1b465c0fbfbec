// What no recorded camera faced.
#include "host/apps/cli/draw/unseen.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "io/picture/image.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli;
using namespace simuli::test;

/// A camera of 90 degrees at x = 0 and x = 10 m of a rig that looks along its x axis.
SceneFile scene_of_one_camera() {
  SceneFile file;
  Camera camera;
  camera.name = "front";
  camera.width = camera.height = 100;
  camera.fx = camera.fy = camera.cx = camera.cy = 50.0;
  Eigen::Matrix3d rig_from_camera;  // x right, y down, z forward
  rig_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  file.cameras.push_back({camera, Pose{Eigen::Quaterniond(rig_from_camera), Eigen::Vector3d::Zero()}});
  const Pose there{Eigen::Quaterniond::Identity(), Eigen::Vector3d(10.0, 0.0, 0.0)};
  file.world_from_rig = Trajectory({{0.0, Pose{}}, {1.0, there}});
  return file;
}

TEST(RecordedViews, HaveWhatFallsIntoAPicture) {
  const SceneFile file = scene_of_one_camera();
  const cli::RecordedViews views(file);
  EXPECT_FALSE(views.empty());
  EXPECT_TRUE(views.has({5.0, 4.9, 0.0}));
  EXPECT_FALSE(views.has({5.0, 5.1, 0.0}));
  EXPECT_TRUE(views.has({15.0, 14.0, 0.0})) << "from the path's start";
  EXPECT_FALSE(views.has({-1.0, 0.0, 0.0})) << "behind";
  EXPECT_TRUE(views.has({1e5, 0.9e5, 0.9e5}));
  EXPECT_FALSE(views.has({1e5, 1.1e5, 0.0}));
}

TEST(RecordedViews, AreThoseOfRecordedFrames) {
  SceneFile file = scene_of_one_camera();
  file.recorded_frames["front"] = {{1.0, 1.0}};
  const cli::RecordedViews views(file);
  EXPECT_FALSE(views.has({5.0, 0.0, 0.0})) << "the rig was past it";
  EXPECT_TRUE(views.has({15.0, 4.0, 0.0}));
  EXPECT_TRUE(cli::RecordedViews(SceneFile{}).empty());
}

TEST(RecordedViews, KeepThoseNearby) {
  SceneFile file = scene_of_one_camera();
  // Sideways: each camera sees what is beside it, the next one 1 cm on.
  const Eigen::Quaterniond to_the_left(Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()));
  file.world_from_rig =
      Trajectory({{0.0, Pose{to_the_left, {0.0, 0.0, 0.0}}}, {1.0, Pose{to_the_left, {10.0, 0.0, 0.0}}}});
  std::vector<FrameSpan>& spans = file.recorded_frames["front"];
  for (int i = 0; i <= 1000; ++i) spans.push_back({0.001 * i, 0.001 * i});
  const cli::RecordedViews views(file), near = views.around({5.0, 0.0, 0.0});
  const Eigen::Vector3d beside(5.001, 0.02, 0.0), far_off(1.5, 1.0, 0.0);
  EXPECT_TRUE(views.has(beside));
  EXPECT_TRUE(near.has(beside));
  EXPECT_TRUE(near.has(far_off));
  EXPECT_FALSE(near.has({1.5, -1.0, 0.0}));
}

class UnseenCli : public Cli {};

TEST_F(UnseenCli, WideLensesAreMarkedWhereNothingIsKnown) {
  make_street_scene();
  const auto picture = [&](const std::string& sensor, const std::string& folder, const std::string& more) {
    const Outcome outcome =
        run("render s.scene --sensor " + sensor + " --frames 1:2 -o " + folder + ' ' + more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return read_image(folder_ / folder / (sensor + "_000001.png"));
  };
  const Image plain = picture("tum_vi_cam0", "plain", "--size 128x128");
  const Image marked = picture("tum_vi_cam0", "marked", "--size 128x128 --mark-unseen");
  ASSERT_EQ(plain.data.size(), marked.data.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < plain.data.size(); i += 3) different += plain.data[i] != marked.data[i] ? 1 : 0;
  // 80 x 50 degrees of a circle of 190.
  EXPECT_GT(different, plain.data.size() / 3 / 2);
  EXPECT_LT(different, plain.data.size() / 3 * 95 / 100);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(plain.at(64, 64, c), marked.at(64, 64, c)) << "ahead";
  EXPECT_NE(plain.at(64, 10, 1), marked.at(64, 10, 1)) << "straight up";

  // The camera that was there saw all of it.
  const Image own = picture("front", "own", ""), own_marked = picture("front", "own_marked", "--mark-unseen");
  EXPECT_EQ(own.data, own_marked.data);
  EXPECT_NE(run("render s.scene --sensor front -o l.log --as-log --mark-unseen").exit_code, 0);
}

}  // namespace
