#pragma once
// A small scene on disk, its numbers such that single precision holds every pose; what a client asks of it;
// and what the library gives.
#include <filesystem>
#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "host/apps/serve/messages/handlers.hpp"
#include "host/apps/serve/messages/shot_message.hpp"
#include "host/apps/serve/session/refusal.hpp"
#include "tests/io/scratch.hpp"
#include "tests/support/scenes.hpp"

namespace simuli::test {

inline constexpr const char* kSceneId = "small";

inline GaussianSet served_set(SetKind kind, std::uint64_t seed) {
  GaussianSet set = random_set({.kind = kind,
                                .sh_degree = 1,
                                .count = 300,
                                .low = {4.0, -6.0, -3.0},
                                .high = {24.0, 6.0, 3.0},
                                .scale_min = 0.1,
                                .scale_max = 0.6},
                               seed);
  // The last ones are of actors, within their boxes.
  set.actor.assign(300, 0);
  for (Eigen::Index i = 200; i < 300; ++i) {
    set.actor[static_cast<std::size_t>(i)] = i < 260 ? 1 : 2;
    set.mean().row(i) = 0.1F * set.mean().row(i);
    set.mean()(i, 0) -= 1.4F;
  }
  if (kind == SetKind::kLidar) {  // whatever is met comes back
    set.sh(0).col(1).setConstant(8.0F);
    set.sh(0).col(2).setConstant(-8.0F);
  }
  return set;
}

inline SceneFile served_file() {
  SceneFile file;
  Scene& scene = file.scene;
  scene.name = "small";
  scene.origin = {512.0, -1024.0, 8.0};
  scene.camera = served_set(SetKind::kCamera, 1);
  scene.lidar = served_set(SetKind::kLidar, 2);
  const auto at = [&](double x, double y) {
    return Pose{Eigen::Quaterniond::Identity(), scene.origin + Eigen::Vector3d(x, y, 0.0)};
  };
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {{0.0, at(10.0, 2.0)}, {2.0, at(14.0, 2.0)}}};
  Actor van{"van", "truck", {5.0, 2.0, 2.5}, {{0.0, at(12.0, -2.0)}, {2.0, at(12.0, -2.0)}}};
  van.track[0].world_from_actor.rotation = van.track[1].world_from_actor.rotation =
      Eigen::Quaterniond(0.0, 0.0, 0.0, 1.0);
  scene.actors = {car, van};
  const Pose rig_from_camera{Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {1.5, 0.25, 0.5}};
  Camera front = small_camera(48, 32);
  front.name = "front";
  Camera rolling = small_camera(48, 32, ShutterKind::kTopToBottom);
  rolling.name = "rolling";
  Camera fisheye = small_camera(40, 40);
  fisheye.name = "fisheye";
  fisheye.lens = Lens(LensKind::kOpencvFisheye, {0.01, -0.002, 0.0003, -0.00004, 1.2});
  Camera wide{"wide", 40, 24, 0.0, 0.0, 20.25, 12.5, ShutterKind::kGlobal};
  set_ftheta(wide, LensKind::kFtheta, {17.0, 0.1, -0.3, 0.0, 0.01}, {1.0, 0.0, 0.0}, 1.3);
  Camera mirror = small_camera(32, 24);
  mirror.name = "mirror";
  mirror.lens = Lens(LensKind::kDoubleSphere, {0.1, 0.5, 1.2});
  for (const Camera& camera : {front, rolling, fisheye, wide, mirror}) {
    file.cameras.push_back({camera, rig_from_camera});
  }
  Lidar top = small_lidar(8, 90);
  top.name = "top";
  file.lidars = {{top, {Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.75}}}};
  file.world_from_rig = Trajectory({{0.0, at(0.0, 0.0)}, {1.0, at(4.0, 0.0)}, {2.0, at(8.0, 0.0)}});
  return file;
}

/// The scene on disk and who answers for it; and the same scene with the library.
class Served : public testing::Test {
 protected:
  void SetUp() override {
    write_scene(scratch_ / "small.scene", served_file());
    session_ = std::make_unique<serve::RenderSession>(options());
    handlers_ = std::make_unique<serve::Handlers>(*session_, serve::EgoMasks(), "0123abc");
    scene_ = session_->open(kSceneId);
    file_ = read_scene(scratch_ / "small.scene");
    rig_ = SensorRig(file_);
  }
  [[nodiscard]] serve::SessionOptions options() const {
    serve::SessionOptions options;
    options.scenes = serve::scene_sources({(scratch_ / "small.scene").string()});
    return options;
  }
  /// A scene of the library's, edited as the caller likes.
  [[nodiscard]] SceneOnDevice library() const { return {session_->device(), file_.scene}; }

  /// The sensor carried along the recorded path over whole microseconds, all actors as recorded.
  [[nodiscard]] Shot recorded_shot(const std::string& sensor, double start_s, double end_s) const {
    return Shot::along(file_.world_from_rig, rig_.find(sensor).rig_from_sensor(), start_s, end_s);
  }
  void report_poses(serve::proto::PosePair& pair, const Pose& start, const Pose& end) const {
    *pair.mutable_start_pose() = serve::message_of(scene_->local(start));
    *pair.mutable_end_pose() = serve::message_of(scene_->local(end));
  }
  template <class Objects>
  void report_actors(Objects& objects, double start_s, double end_s) const {
    for (const Actor& actor : file_.scene.actors) {
      serve::proto::DynamicObject& object = *objects.Add();
      object.set_track_id(actor.name);
      report_poses(*object.mutable_pose_pair(), actor.at(start_s), actor.at(end_s));
    }
  }
  [[nodiscard]] serve::proto::RGBRenderRequest picture_request(
      const std::string& camera,
      double start_s,
      double end_s,
      serve::proto::ImageFormat format = serve::proto::RGB_UINT8_PLANAR) const {
    const Camera& own = rig_.find(camera).camera();
    serve::proto::RGBRenderRequest request;
    request.set_scene_id(kSceneId);
    request.set_resolution_w(static_cast<std::uint32_t>(own.width));
    request.set_resolution_h(static_cast<std::uint32_t>(own.height));
    *request.mutable_camera_intrinsics() = serve::spec_of(own);
    request.set_frame_start_us(scene_->microseconds(start_s));
    request.set_frame_end_us(scene_->microseconds(end_s));
    const Shot shot = recorded_shot(camera, start_s, end_s);
    report_poses(*request.mutable_sensor_pose(), shot.world_from_sensor_start, shot.world_from_sensor_end);
    report_actors(*request.mutable_dynamic_objects(), start_s, end_s);
    request.set_image_format(format);
    return request;
  }
  [[nodiscard]] serve::proto::LidarRenderRequest sweep_request(double start_s, double end_s) const {
    serve::proto::LidarRenderRequest request;
    request.set_scene_id(kSceneId);
    request.set_frame_start_us(scene_->microseconds(start_s));
    request.set_frame_end_us(scene_->microseconds(end_s));
    const Shot shot = recorded_shot("top", start_s, end_s);
    report_poses(*request.mutable_sensor_pose(), shot.world_from_sensor_start, shot.world_from_sensor_end);
    report_actors(*request.mutable_dynamic_objects(), start_s, end_s);
    return request;
  }
  [[nodiscard]] std::string rendered(const serve::proto::RGBRenderRequest& request) const {
    serve::proto::RGBRenderReturn reply;
    handlers_->render_rgb({}, request, reply);
    return reply.image_bytes();
  }
  [[nodiscard]] serve::proto::LidarRenderReturn rendered(
      const serve::proto::LidarRenderRequest& request) const {
    serve::proto::LidarRenderReturn reply;
    serve::Call call;
    call.lidar = "top";
    handlers_->render_lidar(call, request, reply);
    return reply;
  }

  Scratch scratch_;
  std::unique_ptr<serve::RenderSession> session_;
  std::unique_ptr<serve::Handlers> handlers_;
  serve::RenderSession::ScenePtr scene_;
  SceneFile file_;
  SensorRig rig_;
};

/// `run` is refused for that reason with one line that holds `part`.
template <class F>
void expect_refusal(serve::RefusalKind kind, const std::string& part, F&& run) {
  try {
    run();
    ADD_FAILURE() << "nothing was refused; expected: " << part;
  } catch (...) {
    const serve::Refusal refusal = serve::refusal_of(std::current_exception());
    const std::string what = refusal.what();
    EXPECT_EQ(static_cast<int>(refusal.kind()), static_cast<int>(kind)) << what;
    EXPECT_NE(what.find(part), std::string::npos) << '"' << what << "\" lacks \"" << part << '"';
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  }
}

}  // namespace simuli::test
