// Scenes that clients change.
#include "host/core/scene/edit.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "host/apps/serve/messages/edit_message.hpp"
#include "host/apps/serve/messages/render_message.hpp"
#include "tests/serve/served_scene.hpp"

namespace simuli::serve {
namespace {

using test::expect_refusal;

class ServedEdits : public test::Served {
 protected:
  void SetUp() override {
    test::Served::SetUp();
    allow();
  }
  void allow(HandlerOptions options = {.allows_edits = true}) {
    handlers_ = std::make_unique<Handlers>(*session_, EgoMasks(), "0123abc", std::move(options));
  }
  /// 3 m to the left of the car's track.
  [[nodiscard]] std::vector<KeyPose> beside() const {
    std::vector<KeyPose> track = file_.scene.actors[0].track;
    for (KeyPose& key : track) key.world_from_actor.translation.y() += 3.0;
    return track;
  }
  [[nodiscard]] proto::EditAssetsRequest insertion(const std::string& id = "second") const {
    proto::EditAssetsRequest request;
    request.set_scene_id(test::kSceneId);
    proto::DynamicObjectTrack& object = *request.add_insert();
    object.set_id(id);
    object.set_asset_id("car");
    object.set_semantic_class("taxi");
    for (const KeyPose& key : beside()) {
      proto_common::PoseAtTime& pose = *object.mutable_trajectory()->add_poses();
      pose.set_timestamp_us(scene_->microseconds(key.time_s));
      *pose.mutable_pose() = message_of(scene_->local(key.world_from_actor));
    }
    return request;
  }
  [[nodiscard]] proto::EditAssetsRequest replacement() const {
    proto::EditAssetsRequest request;
    request.set_scene_id(test::kSceneId);
    proto::ReplaceAssetAction& action = *request.add_replace();
    action.set_original_id("van");
    action.set_replacement_id("car");
    return request;
  }
  [[nodiscard]] proto::EditAssetsResponse edit(const proto::EditAssetsRequest& request) const {
    proto::EditAssetsResponse reply;
    handlers_->edit_assets({}, request, reply);
    EXPECT_EQ(reply.success(), reply.message().empty()) << reply.message();
    return reply;
  }
  void restore() const {
    proto::RestoreModelParametersRequest request;
    request.set_scene_id(test::kSceneId);
    handlers_->restore_model_parameters({}, request);
  }
  [[nodiscard]] std::vector<std::string> external() const {
    proto::ExternalAssetObjectsRequest request;
    request.set_scene_id(test::kSceneId);
    proto::ExternalAssetObjectsReturn reply;
    handlers_->get_external_asset_objects({}, request, reply);
    return {reply.track_ids().begin(), reply.track_ids().end()};
  }
  /// The picture of the library's scene after `change`, its recorded actors where picture_request() has them.
  template <class Change>
  [[nodiscard]] std::string changed(const proto::RGBRenderRequest& request, const Change& change) const {
    Scene scene = file_.scene;
    change(scene);
    SceneOnDevice on_device(session_->device(), std::move(scene));
    const Camera camera = requested_camera(*scene_, request);
    const FrameMessage frame{
        request.frame_start_us(), request.frame_end_us(), request.sensor_pose(), request.dynamic_objects()};
    const Shot shot = camera_shot(*scene_, frame, camera);
    return PictureBytes(session_->device())
        .start(on_device.render(Sensor(camera), shot), PixelOrder::kPlanar)
        .take();
  }
};

TEST_F(ServedEdits, WhoIsInsertedIsOnItsOwnTrack) {
  const auto request = picture_request("front", 0.5, 0.5);
  const std::string before = rendered(request);
  EXPECT_TRUE(edit(insertion()).success());
  const std::string after = rendered(request);
  EXPECT_NE(after, before);
  EXPECT_EQ(after, changed(request, [&](Scene& scene) {
              duplicate_actor(scene, "car", "second");
              retrack_actor(scene, "second", beside());
            }));
  EXPECT_EQ(external(), std::vector<std::string>{"second"});
  proto::AvailableDynamicObjectsRequest of_scene;
  of_scene.set_scene_id(test::kSceneId);
  proto::AvailableDynamicObjectsReturn objects;
  handlers_->get_dynamic_objects({}, of_scene, objects);
  ASSERT_EQ(objects.dynamic_objects_size(), 3);
  EXPECT_EQ(objects.dynamic_objects(2).id(), "second");
  EXPECT_EQ(objects.dynamic_objects(2).semantic_class(), "taxi");
  // A request that names it has it elsewhere.
  auto named = request;
  proto::DynamicObject& object = *named.add_dynamic_objects();
  object.set_track_id("second");
  const Pose elsewhere = file_.scene.actors[1].at(0.5);
  report_poses(*object.mutable_pose_pair(), elsewhere, elsewhere);
  EXPECT_EQ(rendered(named), changed(request, [&](Scene& scene) {
              duplicate_actor(scene, "car", "second");
              retrack_actor(scene, "second", {{0.5, elsewhere}});
            }));
}

TEST_F(ServedEdits, WhoIsReplacedKeepsItsTrackAndStandsOnTheGround) {
  const auto request = picture_request("front", 0.5, 0.5);
  EXPECT_TRUE(edit(replacement()).success());
  const auto& actors = session_->open(test::kSceneId)->scene().actors;
  ASSERT_EQ(actors.size(), 2U);
  const Actor& van = actors[find_actor(actors, "van")];
  EXPECT_EQ(van.size_m, Eigen::Vector3d(4.0, 2.0, 1.5));
  // 2.5 m high, then 1.5 m: half a metre lower.
  const Pose was = file_.scene.actors[1].at(0.5), is = van.at(0.5);
  EXPECT_TRUE(is.translation.isApprox(was.translation - Eigen::Vector3d(0.0, 0.0, 0.5), 1e-12));
  EXPECT_EQ(external(), std::vector<std::string>{"van"});
  // Where the request has it: of the car's particles.
  EXPECT_EQ(rendered(request), changed(request, [&](Scene& scene) {
              const std::vector<KeyPose> track = scene.actors[1].track;
              remove_actor(scene, "van");
              duplicate_actor(scene, "car", "van");
              retrack_actor(scene, "van", track);
            }));
}

TEST_F(ServedEdits, NamesAndKindsAreAsInFiles) {
  for (const char* const name : {"..", "../x", "a/b", "a\n", "\xE2\x80\xAE", ""}) {
    auto request = insertion();
    request.mutable_insert(0)->set_id(name);
    const auto reply = edit(request);
    EXPECT_FALSE(reply.success()) << name;
    EXPECT_NE(reply.message().find("insert 0.id"), std::string::npos) << reply.message();
  }
  auto request = insertion();
  request.mutable_insert(0)->set_semantic_class("a\x1b[2J\nb");
  EXPECT_TRUE(edit(request).success());
  EXPECT_EQ(session_->open(test::kSceneId)->scene().actors.back().kind, "a\\x1b[2J\\x0ab");
}

TEST_F(ServedEdits, ASizeIsAFactor) {
  auto request = insertion();
  request.mutable_insert(0)->mutable_object_size()->set_size_x(8.0F);
  request.mutable_insert(0)->mutable_object_size()->set_size_y(4.0F);
  request.mutable_insert(0)->mutable_object_size()->set_size_z(3.0F);
  EXPECT_TRUE(edit(request).success());
  const auto& actors = session_->open(test::kSceneId)->scene().actors;
  EXPECT_EQ(actors[2].size_m, Eigen::Vector3d(8.0, 4.0, 3.0));
  // Its middle is where the message has it.
  EXPECT_TRUE(actors[2].at(0.0).translation.isApprox(beside()[0].world_from_actor.translation, 1e-9));
}

TEST_F(ServedEdits, StayUntilTheyAreRestored) {
  const auto request = picture_request("front", 0.5, 0.5);
  const std::string before = rendered(request);
  EXPECT_TRUE(edit(replacement()).success());
  const std::string replaced = rendered(request);
  EXPECT_NE(replaced, before);
  EXPECT_TRUE(edit(insertion()).success());
  EXPECT_NE(rendered(request), replaced);
  EXPECT_EQ(external(), (std::vector<std::string>{"second", "van"}));
  // Who held the scene has it as it was.
  const auto held = scene_->scene().actors.size();
  EXPECT_EQ(held, 2U);
  restore();
  EXPECT_EQ(rendered(request), before);
  EXPECT_TRUE(external().empty());
  restore();  // of what is as it was
  EXPECT_EQ(rendered(request), before);
  EXPECT_TRUE(edit(insertion()).success());  // the name is free again
}

TEST_F(ServedEdits, OutliveTheirSceneInMemory) {
  SessionOptions options;
  const std::string path = (scratch_ / "small.scene").string();
  options.scenes = scene_sources({"small=" + path, "other=" + path});
  options.cache_size = 1;
  session_ = std::make_unique<RenderSession>(options);
  allow();
  EXPECT_TRUE(edit(replacement()).success());
  EXPECT_TRUE(edit(insertion()).success());
  const auto request = picture_request("front", 0.5, 0.5);
  const std::string edited = rendered(request);
  EXPECT_FALSE(session_->open("other")->is_edited());
  EXPECT_EQ(session_->kept(), std::vector<std::string>{"other"});
  EXPECT_EQ(rendered(request), edited);
  EXPECT_EQ(external(), (std::vector<std::string>{"second", "van"}));
}

TEST_F(ServedEdits, RefusalsChangeNothing) {
  const auto refused = [&](const std::string& part, proto::EditAssetsRequest request) {
    *request.add_insert() = insertion("third").insert(0);  // which would be right
    const auto before = session_->open(test::kSceneId);
    const proto::EditAssetsResponse reply = edit(request);
    EXPECT_FALSE(reply.success());
    EXPECT_NE(reply.message().find(part), std::string::npos) << reply.message() << " lacks " << part;
    EXPECT_EQ(session_->open(test::kSceneId), before);
  };
  const auto inserting = [&](const auto& spoil) {
    auto request = insertion();
    spoil(*request.mutable_insert(0));
    return request;
  };
  refused("insert 0.asset_id: found \"cart\"", inserting([](auto& o) { o.set_asset_id("cart"); }));
  refused("insert 0.id: found \"van\"", inserting([](auto& o) { o.set_id("van"); }));
  refused("insert 0.id: found \"\"", inserting([](auto& o) { o.set_id(""); }));
  refused("insert 0.object_size: found 8 x 2 x 2 m", inserting([](auto& o) {
            o.mutable_object_size()->set_size_x(8.0F);
            o.mutable_object_size()->set_size_y(2.0F);
            o.mutable_object_size()->set_size_z(2.0F);
          }));
  refused("insert 0.object_size",
          inserting([](auto& o) { o.mutable_object_size()->set_size_x(std::nanf("")); }));
  refused("insert 0.trajectory.poses 1.timestamp_us",
          inserting([](auto& o) { o.mutable_trajectory()->mutable_poses(1)->set_timestamp_us(0); }));
  refused("insert 0.trajectory.poses 1.pose.quat", inserting([](auto& o) {
            o.mutable_trajectory()->mutable_poses(1)->mutable_pose()->mutable_quat()->set_w(std::nanf(""));
          }));
  refused("insert 0.trajectory.poses 0.timestamp_us: found 90000000",
          inserting([](auto& o) { o.mutable_trajectory()->mutable_poses(0)->set_timestamp_us(90000000); }));
  auto unknown = replacement();
  unknown.mutable_replace(0)->set_original_id("vna");
  refused("replace 0.original_id: found \"vna\"", unknown);
  auto itself = replacement();
  itself.mutable_replace(0)->set_replacement_id("van");
  refused("replace 0.replacement_id: found \"van\" for itself", itself);
  auto many = insertion();
  for (int i = 0; i < 256; ++i) *many.add_insert() = many.insert(0);
  refused("258 edits", many);
}

TEST_F(ServedEdits, AreAllowedByTheirOwnersAndBounded) {
  allow({.allows_edits = true, .most_more_particles = 0});
  for (int i = 0; i < 5; ++i)
    EXPECT_TRUE(edit(insertion(fmt::format("a{}", i))).success());  // 120 each of 600
  EXPECT_NE(edit(insertion("more")).message().find("found 1320 particles in all, allowed 1200"),
            std::string::npos);
  restore();
  allow();
  auto long_one = insertion();
  long_one.mutable_insert(0)->set_semantic_class(std::string(std::size_t{4} << 20U, 'x'));
  std::string said;
  int made = 0;
  for (; said.empty() && made < 40; ++made) {
    long_one.mutable_insert(0)->set_id(fmt::format("b{}", made));
    said = edit(long_one).message();
  }
  EXPECT_NE(said.find("MiB in all, allowed 64 MiB"), std::string::npos) << said;
  EXPECT_EQ(made, 16);
  EXPECT_FALSE(edit(long_one).success());
  restore();
  EXPECT_TRUE(edit(long_one).success());
  restore();
  allow({});
  expect_refusal(RefusalKind::kPrecondition, "--enable-editing-actors", [&] {
    static_cast<void>(edit(insertion("b")));
  });
  allow();
  auto nowhere = insertion("b");
  nowhere.set_scene_id("nowhere");
  expect_refusal(RefusalKind::kNotFound, "nowhere", [&] { static_cast<void>(edit(nowhere)); });
}

}  // namespace
}  // namespace simuli::serve
