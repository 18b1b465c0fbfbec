// Where units and conventions of poses and times differ.
#include "host/apps/serve/messages/shot_message.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/serve/served_scene.hpp"

namespace simuli::serve {
namespace {

using test::expect_refusal;
using ShotMessage = test::Served;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

FrameMessage frame_of(const proto::RGBRenderRequest& q) {
  return {q.frame_start_us(), q.frame_end_us(), q.sensor_pose(), q.dynamic_objects()};
}

TEST_F(ShotMessage, PosesAreActiveAndQuaternionsBeginWithW) {
  proto_common::Pose message;
  message.mutable_vec()->set_x(1.0F);
  message.mutable_vec()->set_y(2.0F);
  message.mutable_vec()->set_z(3.0F);
  message.mutable_quat()->set_w(std::sqrt(0.5F));
  message.mutable_quat()->set_z(std::sqrt(0.5F));  // a quarter turn to the left
  const Pose a_from_b = pose_of(message, "pose");
  EXPECT_LT((a_from_b * Eigen::Vector3d(1.0, 0.0, 0.0) - Eigen::Vector3d(1.0, 3.0, 3.0)).norm(), 1e-7);
  EXPECT_NEAR(a_from_b.rotation.norm(), 1.0, 1e-15);
  EXPECT_EQ(message_of(a_from_b).SerializeAsString(), message.SerializeAsString());
}

TEST_F(ShotMessage, PlacesAreRelativeToTheScenesOrigin) {
  const Shot shot =
      camera_shot(*scene_, frame_of(picture_request("front", 0.5, 0.5)), file_.cameras[0].model);
  const Shot recorded = recorded_shot("front", 0.5, 0.5);
  EXPECT_EQ(shot.world_from_sensor_start.translation, recorded.world_from_sensor_start.translation);
  EXPECT_EQ(shot.world_from_sensor_start.translation.x(), 512.0 + 2.0 + 1.5);
  proto::AvailableTrajectoriesReturn reply;
  proto::AvailableTrajectoriesRequest request;
  request.set_scene_id("small");
  handlers_->get_available_trajectories({}, request, reply);
  const proto_common::Trajectory& path = reply.available_trajectories(0).trajectory();
  ASSERT_EQ(path.poses_size(), 3);
  EXPECT_EQ(path.poses(1).timestamp_us(), 1000000U);
  EXPECT_EQ(path.poses(1).pose().vec().x(), 4.0F);
  EXPECT_EQ(path.poses(1).pose().vec().z(), 0.0F);
}

TEST_F(ShotMessage, MicrosecondsAreExact) {
  for (const double time_s : {0.0, 0.1, 0.333333, 1.999999, 2.0}) {
    EXPECT_EQ(scene_->seconds(scene_->microseconds(time_s), "t"), time_s);
  }
  expect_refusal(RefusalKind::kOutOfRange, "frame_start_us: found 2300000 us, allowed 0 to 2000000", [&] {
    static_cast<void>(scene_->seconds(2300000, "frame_start_us"));
  });
  for (const std::uint64_t late : {std::uint64_t{1} << 53U, ~std::uint64_t{0}}) {
    expect_refusal(
        RefusalKind::kOutOfRange, "t: found", [&] { static_cast<void>(scene_->seconds(late, "t")); });
  }
}

TEST_F(ShotMessage, TimesBeforeTheLogBeginAreCountedToo) {
  SceneFile early = test::served_file();
  std::vector<TimedPose> poses = early.world_from_rig.poses();
  for (TimedPose& pose : poses) pose.time_s -= 0.25;
  early.world_from_rig = Trajectory(poses);
  write_scene(scratch_ / "early.scene", early);
  const ServedScene scene({"early", scratch_ / "early.scene"});
  EXPECT_EQ(scene.microseconds(-0.25), 750000U);
  EXPECT_EQ(scene.seconds(750000, "t"), -0.25);
  EXPECT_EQ(scene.seconds(1000000, "t"), 0.0);
}

TEST_F(ShotMessage, AGlobalShutterOpensAtTheStart) {
  const auto request = picture_request("front", 0.5, 0.75);
  const Shot shot = camera_shot(*scene_, frame_of(request), file_.cameras[0].model);
  const Shot start = recorded_shot("front", 0.5, 0.5);
  EXPECT_EQ(shot.time_end_s, 0.5);
  EXPECT_EQ(shot.world_from_sensor_end.translation, start.world_from_sensor_start.translation);
}

TEST_F(ShotMessage, ARollingShutterMeetsItsFirstAndLastRowAtStartAndEnd) {
  const auto request = picture_request("rolling", 0.5, 0.75);
  for (const ShutterKind kind : {ShutterKind::kTopToBottom,
                                 ShutterKind::kBottomToTop,
                                 ShutterKind::kLeftToRight,
                                 ShutterKind::kRightToLeft}) {
    Camera camera = file_.cameras[1].model;
    camera.shutter = kind;
    const Shot shot = camera_shot(*scene_, frame_of(request), camera);
    const Eigen::Vector2d first(0.5, 0.5), last(camera.width - 0.5, camera.height - 0.5);
    const bool is_forward = kind == ShutterKind::kTopToBottom || kind == ShutterKind::kLeftToRight;
    const Shot recorded = recorded_shot("rolling", 0.5, 0.75);
    const auto place = [&](const Eigen::Vector2d& pixel) {
      return shot.pose_at(camera.exposure_fraction(pixel)).translation;
    };
    const auto time = [&](const Eigen::Vector2d& pixel) {
      const double share = camera.exposure_fraction(pixel);
      return (1.0 - share) * shot.time_start_s + share * shot.time_end_s;
    };
    EXPECT_LT((place(is_forward ? first : last) - recorded.world_from_sensor_start.translation).norm(), 1e-9);
    EXPECT_LT((place(is_forward ? last : first) - recorded.world_from_sensor_end.translation).norm(), 1e-9);
    EXPECT_NEAR(time(is_forward ? first : last), 0.5, 1e-12);
    EXPECT_NEAR(time(is_forward ? last : first), 0.75, 1e-12);
  }
}

TEST_F(ShotMessage, ActorsAreWhereTheRequestHasThem) {
  auto request = picture_request("rolling", 0.5, 0.75);
  request.mutable_dynamic_objects()->DeleteSubrange(1, 1);
  request.mutable_dynamic_objects(0)->mutable_pose_pair()->mutable_end_pose()->mutable_vec()->set_y(3.0F);
  Camera camera = file_.cameras[1].model;
  const Shot shot = camera_shot(*scene_, frame_of(request), camera);
  const std::vector<ActorView> views = actors_during(file_.scene.actors, shot, file_.scene.origin);
  EXPECT_FALSE(views[1].is_there);
  ASSERT_TRUE(views[0].is_there);
  const double share = camera.exposure_fraction({0.5, camera.height - 0.5});
  const Pose last = interpolate(views[0].scene_from_actor_start, views[0].scene_from_actor_end, share);
  EXPECT_LT((last.translation - Eigen::Vector3d(11.5, 3.0, 0.0)).norm(), 1e-9);
}

TEST_F(ShotMessage, RefusesWhatIsNone) {
  const auto refused = [&](RefusalKind kind,
                           const std::string& part,
                           const std::function<void(proto::RGBRenderRequest&)>& spoil) {
    auto request = picture_request("front", 0.5, 0.75);
    spoil(request);
    expect_refusal(kind, part, [&] {
      static_cast<void>(camera_shot(*scene_, frame_of(request), file_.cameras[0].model));
    });
  };
  constexpr RefusalKind kInvalid = RefusalKind::kInvalid;
  refused(kInvalid, "sensor_pose.start_pose: found none", [](auto& q) { q.mutable_sensor_pose()->Clear(); });
  refused(kInvalid, "sensor_pose.end_pose: found none", [](auto& q) {
    q.mutable_sensor_pose()->clear_end_pose();
  });
  for (const float bad : {kNan, std::numeric_limits<float>::infinity(), 1e30F}) {
    refused(kInvalid, "sensor_pose.start_pose.vec", [&](auto& q) {
      q.mutable_sensor_pose()->mutable_start_pose()->mutable_vec()->set_y(bad);
    });
    refused(kInvalid, "sensor_pose.end_pose.quat", [&](auto& q) {
      q.mutable_sensor_pose()->mutable_end_pose()->mutable_quat()->set_w(bad);
    });
    refused(kInvalid, "dynamic_objects \"van\".end_pose.vec", [&](auto& q) {
      q.mutable_dynamic_objects(1)->mutable_pose_pair()->mutable_end_pose()->mutable_vec()->set_x(bad);
    });
  }
  refused(
      kInvalid, "0, 0, 0, 0", [](auto& q) { q.mutable_sensor_pose()->mutable_start_pose()->clear_quat(); });
  refused(kInvalid, "frame_end_us", [](auto& q) { q.set_frame_end_us(1); });
  refused(RefusalKind::kOutOfRange, "frame_end_us", [](auto& q) { q.set_frame_end_us(1000000000); });
  refused(kInvalid, "track_id: found \"bus\"", [](auto& q) {
    q.mutable_dynamic_objects(0)->set_track_id("bus");
  });
  refused(kInvalid, "dynamic_objects \"van\": found twice", [](auto& q) {
    q.mutable_dynamic_objects(0)->set_track_id("van");
  });
}

}  // namespace
}  // namespace simuli::serve
