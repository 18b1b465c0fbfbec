// Replies are what the library gives for the same shot, bit for bit.
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <thread>

#include "host/apps/serve/messages/render_message.hpp"
#include "host/device/render/scene/readings.hpp"
#include "io/picture/image.hpp"
#include "tests/serve/ego_mask_picture.hpp"
#include "tests/serve/served_scene.hpp"

namespace simuli::serve {
namespace {

using test::expect_refusal;
using ServedFrames = test::Served;

/// [3][height][width] of what a PNG of the picture holds.
std::string planar_of(const Image& image, const test::Scratch& scratch) {
  write_image(scratch / "expected.png", image);
  const Image stored = read_image(scratch / "expected.png");
  const std::size_t pixels = stored.data.size() / 3;
  std::string bytes(stored.data.size(), '\0');
  for (std::size_t i = 0; i < stored.data.size(); ++i) {
    bytes[i % 3 * pixels + i / 3] = static_cast<char>(std::lround(255.0F * stored.data[i]));
  }
  return bytes;
}

template <class T>
std::vector<T> values_of(const std::string& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

bool has_something_to_see(const std::string& planar) {
  return std::any_of(
      planar.begin(), planar.end(), [](char c) { return static_cast<unsigned char>(c) > 100; });
}

/// As CameraShot has it of a rolling shutter: half a row more at either end.
Shot widened(const Shot& shot, int rows) {
  const double more = 0.5 / (rows - 1), more_s = more * (shot.time_end_s - shot.time_start_s);
  return {
      shot.pose_at(-more), shot.pose_at(1.0 + more), shot.time_start_s - more_s, shot.time_end_s + more_s};
}

TEST_F(ServedFrames, PicturesAreTheLibrarys) {
  SceneOnDevice library = this->library();
  for (const Sensor& sensor : scene_->cameras()) {
    const bool is_rolling = sensor.name() == "rolling";
    const double end_s = is_rolling ? 0.75 : 0.5;
    Shot shot = recorded_shot(sensor.name(), 0.5, end_s);
    if (is_rolling) shot = widened(shot, static_cast<int>(sensor.rows()));
    const Image picture = library.render(sensor, shot).image();
    const std::string planar = rendered(picture_request(sensor.name(), 0.5, end_s));
    EXPECT_EQ(planar, planar_of(picture, scratch_)) << sensor.name();
    EXPECT_TRUE(has_something_to_see(planar)) << sensor.name();
    EXPECT_EQ(rendered(picture_request(sensor.name(), 0.5, end_s, proto::PNG)),
              encode_image(picture, ImageCode::kPng));
    auto jpeg = picture_request(sensor.name(), 0.5, end_s, proto::JPEG);
    EXPECT_EQ(rendered(jpeg), encode_image(picture, ImageCode::kJpeg, 95));
    jpeg.set_image_quality(40.4F);
    EXPECT_EQ(rendered(jpeg), encode_image(picture, ImageCode::kJpeg, 40));
  }
}

/// Without loss, whatever the quality.
TEST_F(ServedFrames, Jpeg2000HoldsThePlanarPicture) {
  auto request = picture_request("front", 0.5, 0.5, proto::JPEG2000);
  request.set_image_quality(10.0F);
  const std::string stored = test::stored_bytes(scratch_.file("served.jp2", rendered(request)));
  const std::string planar = rendered(picture_request("front", 0.5, 0.5));
  ASSERT_EQ(stored.size(), planar.size());
  for (std::size_t i = 0; i < stored.size(); ++i) {
    ASSERT_EQ(stored[i], planar[i % 3 * stored.size() / 3 + i / 3]) << i;
  }
  request.set_resolution_h(31);
  expect_refusal(RefusalKind::kInvalid, "48 x 31 px", [&] { static_cast<void>(rendered(request)); });
}

TEST_F(ServedFrames, PicturesOfAnotherSizeAreTheLibrarys) {
  SceneOnDevice library = this->library();
  auto request = picture_request("front", 0.5, 0.5);
  request.set_resolution_w(30);
  request.set_resolution_h(31);
  const Sensor sensor = rig_.find("front").resized(30, 31);
  EXPECT_EQ(rendered(request),
            planar_of(library.render(sensor, recorded_shot("front", 0.5, 0.5)).image(), scratch_));
}

void expect_sweep(const Sensor& lidar, const Frame& frame, const proto::LidarRenderReturn& reply) {
  const std::vector<Eigen::Vector3d> world = frame.points(PointFrame::kWorld);
  const LidarFrame readings = frame.lidar();
  const Pose end_from_world = frame.shot().world_from_sensor_end.inverse();
  std::vector<float> places, intensities;
  std::vector<std::uint16_t> rings;
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (!readings.is_return(i)) continue;
    const Eigen::Vector3d at = end_from_world * world[i];
    places.insert(places.end(),
                  {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z())});
    intensities.push_back(readings.intensity[i]);
    rings.push_back(static_cast<std::uint16_t>(i / lidar.columns()));
  }
  ASSERT_GT(intensities.size(), 20U);
  EXPECT_EQ(reply.num_points(), intensities.size());
  EXPECT_EQ(values_of<float>(reply.point_xyzs_buffer()), places);
  EXPECT_EQ(values_of<float>(reply.point_intensities_buffer()), intensities);
  EXPECT_EQ(values_of<std::uint16_t>(reply.point_ring_ids_buffer()), rings);
  EXPECT_EQ(reply.point_xyzs_size() + reply.point_intensities_size() + reply.point_ring_ids_size(), 0);
}

TEST_F(ServedFrames, SweepsAreTheLibrarysSeenFromTheirEnd) {
  SceneOnDevice library = this->library();
  const Sensor lidar = rig_.find("top");
  expect_sweep(
      lidar, library.render(lidar, recorded_shot("top", 0.5, 0.625)), rendered(sweep_request(0.5, 0.625)));
  // By the protocol's types, which are built in here.
  auto request = sweep_request(0.5, 0.5);
  for (const auto& [type, name] :
       {std::pair{proto::PANDAR128, "hesai_pandar128"}, {proto::AT128, "ncore_hesai_at128"}}) {
    request.mutable_lidar_config()->set_lidar_type(type);
    proto::LidarRenderReturn reply;
    handlers_->render_lidar({}, request, reply);
    const Sensor built_in = Sensor(builtin_lidar(name));
    expect_sweep(built_in, library.render(built_in, recorded_shot("top", 0.5, 0.5)), reply);
  }
}

TEST_F(ServedFrames, FiltersOfReturnsAreThresholds) {
  SceneOnDevice library = this->library();
  const Frame frame = library.render(rig_.find("top"), recorded_shot("top", 0.5, 0.5));
  const auto count = [&](double most_drop, double least_opacity) {
    std::size_t returned = 0;
    const RayResults& r = frame.results();
    for (std::size_t i = 0; i < r.rays; ++i) {
      const bool is_there = static_cast<double>(r.drop_probability(i)) <= most_drop &&
                            1.0 - static_cast<double>(r.transmittance[i]) >= least_opacity;
      if (is_there && r.expected_distance(i) > 0.0F) ++returned;
    }
    return returned;
  };
  auto request = sweep_request(0.5, 0.5);
  EXPECT_EQ(rendered(request).num_points(), count(0.5, 0.0));
  request.mutable_render_filter()->set_raydrop_threshold(0.9375F);
  EXPECT_EQ(rendered(request).num_points(), count(0.9375, 0.0));
  EXPECT_GT(rendered(request).num_points(), count(0.5, 0.0));
  request.mutable_render_filter()->set_opacity_threshold(0.875F);
  EXPECT_EQ(rendered(request).num_points(), count(0.9375, 0.875));
  EXPECT_LT(rendered(request).num_points(), count(0.9375, 0.0));
  request.mutable_render_filter()->set_raydrop_threshold(1.5F);
  expect_refusal(RefusalKind::kInvalid, "raydrop_threshold", [&] { static_cast<void>(rendered(request)); });
  request.mutable_render_filter()->clear_raydrop_threshold();
  request.mutable_render_filter()->set_enable_distance_filter(true);
  expect_refusal(
      RefusalKind::kUnimplemented, "distance_filter", [&] { static_cast<void>(rendered(request)); });
}

TEST_F(ServedFrames, AnActorLeftOutIsRemoved) {
  auto request = picture_request("front", 0.5, 0.5);
  const std::string with_both = rendered(request);
  request.mutable_dynamic_objects()->DeleteSubrange(0, 1);
  Scene scene = file_.scene;
  remove_actor(scene, "car");
  SceneOnDevice without(session_->device(), scene);
  const Sensor camera = rig_.find("front"), lidar = rig_.find("top");
  const std::string alone = rendered(request);
  EXPECT_EQ(alone, planar_of(without.render(camera, recorded_shot("front", 0.5, 0.5)).image(), scratch_));
  EXPECT_NE(alone, with_both);
  auto sweep = sweep_request(0.5, 0.625);
  sweep.mutable_dynamic_objects()->DeleteSubrange(0, 1);
  expect_sweep(lidar, without.render(lidar, recorded_shot("top", 0.5, 0.625)), rendered(sweep));
}

TEST_F(ServedFrames, AnActorElsewhereIsThere) {
  auto request = picture_request("front", 0.5, 0.5);
  const std::string recorded = rendered(request);
  for (auto* const pose : {request.mutable_dynamic_objects(0)->mutable_pose_pair()->mutable_start_pose(),
                           request.mutable_dynamic_objects(0)->mutable_pose_pair()->mutable_end_pose()}) {
    pose->mutable_vec()->set_y(pose->vec().y() - 1.0F);
  }
  Scene scene = file_.scene;
  move_actor(scene, "car", {0.0, -1.0, 0.0});
  SceneOnDevice moved(session_->device(), scene);
  const std::string elsewhere = rendered(request);
  EXPECT_EQ(elsewhere,
            planar_of(moved.render(rig_.find("front"), recorded_shot("front", 0.5, 0.5)).image(), scratch_));
  EXPECT_NE(elsewhere, recorded);
}

TEST_F(ServedFrames, FourCallersGetWhatOneGets) {
  const std::array<proto::RGBRenderRequest, 4> requests{picture_request("front", 0.5, 0.5),
                                                        picture_request("rolling", 0.25, 0.5),
                                                        picture_request("fisheye", 1.0, 1.0, proto::PNG),
                                                        picture_request("wide", 1.5, 1.5)};
  const auto sweep = sweep_request(0.5, 0.625);
  std::array<std::string, 4> alone;
  for (std::size_t i = 0; i < 4; ++i) alone[i] = rendered(requests[i]);
  const std::string sweep_alone = rendered(sweep).SerializeAsString();
  std::array<int, 4> different{};
  {
    std::vector<std::jthread> callers;
    for (std::size_t k = 0; k < 4; ++k) {
      callers.emplace_back([&, k] {
        for (std::size_t round = 0; round < 6; ++round) {
          const std::size_t i = (k + round) % 4;
          different[k] += rendered(requests[i]) == alone[i] ? 0 : 1;
          different[k] += rendered(sweep).SerializeAsString() == sweep_alone ? 0 : 1;
        }
      });
    }
  }
  EXPECT_EQ(different, (std::array<int, 4>{}));
}

TEST_F(ServedFrames, ABatchTellsOfEachItem) {
  proto::BatchRGBRenderRequest batch;
  const auto add = [&](const std::string& name, const proto::RGBRenderRequest& request) {
    auto& item = *batch.add_items();
    item.set_camera_name(name);
    *item.mutable_request() = request;
  };
  add("a", picture_request("front", 0.5, 0.5));
  auto unknown = picture_request("front", 0.5, 0.5);
  unknown.set_scene_id("elsewhere");
  add("b", unknown);
  add("c", picture_request("rolling", 0.5, 0.75, proto::PNG));
  auto wide = picture_request("front", 0.5, 0.5);  // more than a JPEG's coder takes
  wide.set_resolution_w(65501);
  wide.set_resolution_h(1);
  EXPECT_THROW(static_cast<void>(rendered(wide)), std::exception);
  auto huge = picture_request("front", 0.5, 0.5);
  huge.set_resolution_w(100000);
  huge.set_resolution_h(100000);
  add("d", huge);
  proto::BatchRGBRenderReturn reply;
  handlers_->batch_render_rgb({}, batch, reply);
  ASSERT_EQ(reply.items_size(), 4);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(reply.items(i).camera_name(), batch.items(i).camera_name());
  EXPECT_TRUE(reply.items(0).success());
  EXPECT_EQ(reply.items(0).result().image_bytes(), rendered(batch.items(0).request()));
  EXPECT_EQ(reply.items(0).error_message(), "");
  EXPECT_FALSE(reply.items(1).success());
  EXPECT_FALSE(reply.items(1).has_result());
  EXPECT_NE(reply.items(1).error_message().find("scene_id: found \"elsewhere\""), std::string::npos);
  EXPECT_TRUE(reply.items(2).success());
  EXPECT_EQ(reply.items(2).result().image_bytes(), rendered(batch.items(2).request()));
  EXPECT_FALSE(reply.items(3).success());
  EXPECT_NE(reply.items(3).error_message().find("100000 x 100000"), std::string::npos);

  batch.clear_items();
  auto large = picture_request("front", 0.5, 0.5);
  large.set_resolution_w(4096);
  large.set_resolution_h(4096);
  for (int i = 0; i < 5; ++i) add("e", large);
  expect_refusal(RefusalKind::kInvalid, "pixels of all pictures", [&] {
    handlers_->batch_render_rgb({}, batch, reply);
  });
  batch.clear_items();
  for (int i = 0; i < 300; ++i) add("f", unknown);
  expect_refusal(
      RefusalKind::kInvalid, "items: found 300", [&] { handlers_->batch_render_rgb({}, batch, reply); });
}

TEST_F(ServedFrames, TogetherAreThoseAlone) {
  proto::AggregatedRenderRequest request;
  *request.add_rgb_requests() = picture_request("front", 0.5, 0.5);
  *request.add_rgb_requests() = picture_request("wide", 0.5, 0.5, proto::PNG);
  *request.add_lidar_requests() = sweep_request(0.5, 0.625);
  proto::AggregatedRenderReturn reply;
  Call call;
  call.lidar = "top";
  handlers_->render_aggregated(call, request, reply);
  ASSERT_EQ(reply.rgb_returns_size(), 2);
  ASSERT_EQ(reply.lidar_returns_size(), 1);
  for (int i = 0; i < 2; ++i)
    EXPECT_EQ(reply.rgb_returns(i).image_bytes(), rendered(request.rgb_requests(i)));
  EXPECT_EQ(reply.lidar_returns(0).SerializeAsString(),
            rendered(request.lidar_requests(0)).SerializeAsString());
  request.mutable_rgb_requests(1)->set_image_format(proto::UNDEFINED);
  expect_refusal(RefusalKind::kInvalid, "image_format: found 0", [&] {
    handlers_->render_aggregated(call, request, reply);
  });
}

TEST_F(ServedFrames, RefusesWhatIsNotRendered) {
  const auto refused = [&](RefusalKind kind,
                           const std::string& part,
                           const std::function<void(proto::RGBRenderRequest&)>& spoil) {
    auto request = picture_request("front", 0.5, 0.5);
    spoil(request);
    expect_refusal(kind, part, [&] { static_cast<void>(rendered(request)); });
  };
  refused(RefusalKind::kNotFound, "scene_id: found \"smal\", allowed small", [](auto& q) {
    q.set_scene_id("smal");
  });
  refused(RefusalKind::kInvalid, "image_format: found 99", [](auto& q) {
    q.set_image_format(static_cast<proto::ImageFormat>(99));
  });
  refused(RefusalKind::kInvalid, "resolution: found 48 x 0 px", [](auto& q) { q.set_resolution_h(0); });
  refused(RefusalKind::kInvalid, "resolution: found 0 x 32 px", [](auto& q) { q.set_resolution_w(0); });
  refused(
      RefusalKind::kInvalid, "resolution: found 65536 x 32 px", [](auto& q) { q.set_resolution_w(65536); });
  for (const auto format : {proto::AVC, proto::AV1}) {
    refused(RefusalKind::kUnimplemented, "image_format", [&](auto& q) { q.set_image_format(format); });
  }
  for (const float quality : {-1.0F, 101.0F, std::nanf("")}) {
    refused(RefusalKind::kInvalid, "image_quality", [&](auto& q) { q.set_image_quality(quality); });
  }
  refused(RefusalKind::kNotFound, "ego_mask_id", [](auto& q) { q.set_insert_ego_mask(true); });
  auto sweep = sweep_request(0.5, 0.5);
  sweep.mutable_lidar_config()->set_lidar_type(static_cast<proto::LidarDeviceType>(7));
  proto::LidarRenderReturn reply;
  expect_refusal(
      RefusalKind::kInvalid, "lidar_type: found 7", [&] { handlers_->render_lidar({}, sweep, reply); });
  for (const char* const name : {"nobody", "front", "/etc/passwd"}) {
    Call call;
    call.lidar = name;
    expect_refusal(
        RefusalKind::kNotFound, "sensor: found", [&] { handlers_->render_lidar(call, sweep, reply); });
  }
}

TEST_F(ServedFrames, WhoGivesUpIsNotWaitedFor) {
  Call call;
  int requested = 0;
  call.is_given_up = [&] { return ++requested > 1; };
  proto::RGBRenderReturn reply;
  expect_refusal(RefusalKind::kCancelled, "cancelled", [&] {
    handlers_->render_rgb(call, picture_request("front", 0.5, 0.5), reply);
  });
  EXPECT_FALSE(rendered(picture_request("front", 0.5, 0.5)).empty());
}

}  // namespace
}  // namespace simuli::serve
