// Tests the particles kept by a trained chunk, and the merging of chunks.
#include "optim/train/chunk/chunk_scene.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

#include "host/core/scene/occluders.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/train/chunk/chunk_parts.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

/// A straight drive of 60 m in 6 s.
Log straight_drive() {
  Log log;
  log.name = "straight";
  std::vector<TimedPose> poses;
  for (int k = 0; k <= 60; ++k) {
    Pose pose;
    pose.translation.x() = k;
    poses.push_back({0.1 * k, pose});
  }
  log.world_from_rig = Trajectory(std::move(poses));
  for (int k = 0; k < 60; ++k) log.sweeps.push_back({"top", "", 0.1 * k, 0.1 * k + 0.1});
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  for (int k = 0; k <= 60; ++k) car.track.push_back({0.1 * k, log.world_from_rig.at(0.1 * k)});
  log.actors = {car};
  return log;
}

GaussianSet set_at(SetKind kind, const std::vector<double>& x, std::vector<std::uint32_t> owners) {
  GaussianSet set(kind, 0, static_cast<Eigen::Index>(x.size()));
  for (std::size_t i = 0; i < x.size(); ++i)
    set.mean()(static_cast<Eigen::Index>(i), 0) = static_cast<float>(x[i]);
  set.actor = std::move(owners);
  return set;
}

std::vector<float> places(const GaussianSet& set, std::uint32_t owner) {
  std::vector<float> out;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    if (set.actor[static_cast<std::size_t>(i)] == owner) out.push_back(set.mean()(i, 0));
  }
  std::sort(out.begin(), out.end());
  return out;
}

class ChunkSceneTest : public testing::Test {
 protected:
  /// Returns a position on the trajectory relative to the scene origin.
  [[nodiscard]] double at(double x) const { return x - scene_origin(log_.world_from_rig).x(); }
  /// Returns the scene of a chunk, with two chunks of 30 m: the car, and particles of the background, of the
  /// car, disoccluded and inpainted, on both sides of the border.
  [[nodiscard]] Scene chunk() const {
    const std::vector<double> x{at(10.0), at(50.0), 0.0, at(20.0), at(40.0), at(21.0), at(41.0)};
    const std::vector<std::uint32_t> owners{0, 0, 1, 2, 2, 3, 3};
    Scene scene;
    scene.origin = scene_origin(log_.world_from_rig);
    scene.actors = log_.actors;
    scene.occluders = log_.actors;
    scene.camera = set_at(SetKind::kCamera, x, owners);
    scene.lidar = set_at(SetKind::kLidar, x, owners);
    return scene;
  }

  Log log_ = straight_drive();
  DrivenPath path_{log_};
  std::vector<DriveChunk> chunks_ = cut(path_, {.length_m = 30.0});
  ChunkSplit parting_{path_, chunks_, 10.0};
};

TEST_F(ChunkSceneTest, KeepsAllThatItsCamerasSeeAndItsOwnOfTheLidars) {
  const Scene kept = owned(chunk(), parting_, 0);
  EXPECT_EQ(kept.camera.params, chunk().camera.params);
  EXPECT_EQ(kept.camera.actor, chunk().camera.actor);
  EXPECT_EQ(places(kept.lidar, 0), (std::vector<float>{static_cast<float>(at(10.0))}));
  EXPECT_EQ(places(kept.lidar, 1).size(), 1U);  // actors' particles are in the actor's frame
  EXPECT_EQ(places(kept.lidar, 2), (std::vector<float>{static_cast<float>(at(20.0))}));
  EXPECT_EQ(places(kept.lidar, 3), (std::vector<float>{static_cast<float>(at(21.0))}));
}

TEST_F(ChunkSceneTest, BecomeOneWithAVistaEach) {
  const test::Scratch scratch;
  std::vector<ChunkScene> parts(2);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i].scene = owned(chunk(), parting_, i);
    // As read by a resumed training.
    write_chunk(scratch / std::to_string(i), "settings", parts[i]);
    parts[i] = read_chunk(scratch / std::to_string(i), "settings");
    ASSERT_EQ(parts[i].scene.occluders.size(), 1U);
    EXPECT_EQ(parts[i].scene.occluders[0].track.size(), 61U);
  }
  const auto part = [&](std::size_t i) -> const ChunkScene& { return parts[i]; };
  const Scene one = merged(2, part, log_.actors, parting_);
  ASSERT_EQ(one.visibility_sets.size(), 2U);
  EXPECT_TRUE(one.occluders.empty());
  EXPECT_EQ(one.camera.size(), 2 * 6 + 1);  // the car belongs to one chunk
  EXPECT_EQ(one.lidar.size(), 2 * 3 + 1);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(one.visibility_sets[i].occluders.size(), 1U);
    EXPECT_EQ(one.visibility_sets[i].occluders[0].name, "car");
    const auto all = [&](std::uint32_t owner) { return places(chunk().camera, owner); };
    EXPECT_EQ(places(one.camera, number_of_visibility_set(one, i)), all(0));
    EXPECT_EQ(places(one.camera, disoccluded_number(one, i)), all(2));
    EXPECT_EQ(places(one.camera, inpainted_number(one, i)), all(3));
    EXPECT_EQ(places(one.lidar, number_of_visibility_set(one, i)), std::vector<float>{});
    EXPECT_EQ(places(one.lidar, disoccluded_number(one, i)), (std::vector<float>{all(2)[i]}));
    EXPECT_EQ(places(one.lidar, inpainted_number(one, i)), (std::vector<float>{all(3)[i]}));
  }
  EXPECT_EQ(places(one.lidar, 0), places(chunk().lidar, 0));
}

// The numbers of disoccluded and inpainted particles follow those of the part's visibility sets.
TEST_F(ChunkSceneTest, PartsWithVisibilitySetsKeepHiddenParticles) {
  std::vector<ChunkScene> parts(2);
  for (ChunkScene& part : parts) {
    part.scene.actors = part.scene.occluders = log_.actors;
    part.scene.visibility_sets = {{{Eigen::Vector3d::Zero()}}};
    part.scene.camera =
        set_at(SetKind::kCamera, {1.0, 2.0}, {disoccluded_number(part.scene, 0), inpainted_number(part.scene, 0)});
  }
  const auto part = [&](std::size_t i) -> const ChunkScene& { return parts[i]; };
  const Scene one = merged(2, part, log_.actors, parting_);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(places(one.camera, disoccluded_number(one, i)), std::vector<float>{1.0F});
    EXPECT_EQ(places(one.camera, inpainted_number(one, i)), std::vector<float>{2.0F});
  }
}

// Occluders of one chunk were recorded near it.
TEST_F(ChunkSceneTest, OccludersAreKeptNearTheirChunk) {
  Log log;
  std::vector<TimedPose> poses;
  for (int k = 0; k <= 600; ++k) {
    Pose pose;
    pose.translation.x() = k;
    poses.push_back({0.1 * k, pose});
  }
  log.world_from_rig = Trajectory(std::move(poses));
  log.sweeps = {{"top", "", 0.0, 60.0}};
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  for (int k = 0; k <= 600; ++k) car.track.push_back({0.1 * k, {}});
  const DrivenPath path(log);
  const std::vector<DriveChunk> chunks = cut(path, {.length_m = 100.0});
  std::vector<ChunkScene> parts(6);
  for (ChunkScene& part : parts) {
    part.scene.actors = part.scene.occluders = {car};
    part.scene.camera = set_at(SetKind::kCamera, {0.0}, {2});
  }
  const auto part = [&](std::size_t i) -> const ChunkScene& { return parts[i]; };
  const Scene one = merged(6, part, {car}, {path, chunks, 20.0});
  EXPECT_EQ(one.visibility_sets[0].occluders[0].track.size(), 201U);
  EXPECT_EQ(one.visibility_sets[2].occluders[0].track.size(), 301U);
  EXPECT_EQ(one.actors[0].track.size(), 601U);
}

}  // namespace
}  // namespace simuli
