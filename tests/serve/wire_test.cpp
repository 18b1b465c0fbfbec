// Field numbers: what a client's bytes mean, and which bytes a reply is.
#include "tests/serve/wire.hpp"

#include <gtest/gtest.h>

#include "host/apps/serve/messages/camera_message.hpp"

namespace simuli::serve {
namespace {

using test::Wire;

Wire pose_wire(float x) {
  return Wire()
      .message(1, Wire().real32(1, x).real32(2, x + 1).real32(3, x + 2))
      .message(2, Wire().real32(1, 0.5F).real32(2, -0.5F).real32(3, 0.25F).real32(4, -0.25F));
}
Wire pair_wire(float x) { return Wire().message(1, pose_wire(x)).message(2, pose_wire(x + 10)); }
Wire object_wire() { return Wire().text(1, "car").message(2, pair_wire(100)); }

void expect_pose(const proto_common::Pose& pose, float x) {
  EXPECT_EQ(pose.vec().x(), x);
  EXPECT_EQ(pose.vec().y(), x + 1);
  EXPECT_EQ(pose.vec().z(), x + 2);
  EXPECT_EQ(pose.quat().w(), 0.5F);
  EXPECT_EQ(pose.quat().x(), -0.5F);
  EXPECT_EQ(pose.quat().y(), 0.25F);
  EXPECT_EQ(pose.quat().z(), -0.25F);
}
void expect_pair(const proto::PosePair& pair, float x) {
  expect_pose(pair.start_pose(), x);
  expect_pose(pair.end_pose(), x + 10);
}

/// Every field is known: nothing is kept as unknown.
template <class Message>
Message parsed(const Wire& wire) {
  Message message;
  EXPECT_TRUE(message.ParseFromString(wire.bytes()));
  EXPECT_TRUE(message.GetReflection()->GetUnknownFields(message).empty());
  return message;
}

TEST(Wire, ReadsARequestForAPicture) {
  const Wire pinhole = Wire()
                           .real64(1, 320.5)
                           .real64(2, 180.25)
                           .real64(3, 300)
                           .real64(4, 301)
                           .packed<double>(5, {1, 2, 3, 4, 5, 6})
                           .packed<double>(6, {7, 8})
                           .packed<double>(7, {9, 10, 11, 12});
  const Wire windshield = Wire()
                              .varint(1, 1)
                              .packed<double>(2, {1, 2})
                              .packed<double>(3, {3})
                              .packed<double>(4, {4})
                              .packed<double>(5, {5});
  const Wire camera = Wire()
                          .text(1, "old")
                          .message(3, pinhole)
                          .text(5, "front")
                          .varint(7, 360)
                          .varint(8, 640)
                          .varint(9, 3)
                          .message(10, windshield);
  const Wire bytes = Wire()
                         .text(1, "drive")
                         .varint(2, 180)
                         .varint(3, 320)
                         .message(4, camera)
                         .fixed64(5, 1700000000000001)
                         .fixed64(6, 1700000000033334)
                         .message(7, pair_wire(1))
                         .message(8, object_wire())
                         .varint(9, 4)
                         .real32(10, 95)
                         .varint(11, 1)
                         .message(12, Wire().text(1, "front").text(2, "rig"));
  const auto request = parsed<proto::RGBRenderRequest>(bytes);
  EXPECT_EQ(request.scene_id(), "drive");
  EXPECT_EQ(request.resolution_h(), 180U);
  EXPECT_EQ(request.resolution_w(), 320U);
  EXPECT_EQ(request.frame_start_us(), 1700000000000001U);
  EXPECT_EQ(request.frame_end_us(), 1700000000033334U);
  expect_pair(request.sensor_pose(), 1);
  ASSERT_EQ(request.dynamic_objects_size(), 1);
  EXPECT_EQ(request.dynamic_objects(0).track_id(), "car");
  expect_pair(request.dynamic_objects(0).pose_pair(), 100);
  EXPECT_EQ(request.image_format(), proto::RGB_UINT8_PLANAR);
  EXPECT_EQ(request.image_quality(), 95.0F);
  EXPECT_TRUE(request.insert_ego_mask());
  EXPECT_EQ(request.ego_mask_id().camera_logical_id(), "front");
  EXPECT_EQ(request.ego_mask_id().rig_config_id(), "rig");
  const proto::CameraSpec& spec = request.camera_intrinsics();
  EXPECT_EQ(spec.temporary_camera_spec(), "old");
  EXPECT_EQ(spec.logical_id(), "front");
  EXPECT_EQ(spec.resolution_h(), 360U);
  EXPECT_EQ(spec.resolution_w(), 640U);
  EXPECT_EQ(spec.shutter_type(), proto::ROLLING_BOTTOM_TO_TOP);
  const auto& p = parsed<proto::OpenCVPinholeCameraParam>(pinhole);
  EXPECT_EQ(spec.opencv_pinhole_param().SerializeAsString(), p.SerializeAsString());
  EXPECT_EQ(p.principal_point_x(), 320.5);
  EXPECT_EQ(p.principal_point_y(), 180.25);
  EXPECT_EQ(p.focal_length_x(), 300.0);
  EXPECT_EQ(p.focal_length_y(), 301.0);
  EXPECT_EQ(p.radial_coeffs(5), 6.0);
  EXPECT_EQ(p.tangential_coeffs(1), 8.0);
  EXPECT_EQ(p.thin_prism_coeffs(3), 12.0);
  const auto& w = spec.bivariate_windshield_model_param();
  EXPECT_EQ(w.reference_poly(), proto::BivariateWindshieldModelParameters::BACKWARD);
  EXPECT_EQ(w.horizontal_poly(1), 2.0);
  EXPECT_EQ(w.vertical_poly(0), 3.0);
  EXPECT_EQ(w.horizontal_poly_inverse(0), 4.0);
  EXPECT_EQ(w.vertical_poly_inverse(0), 5.0);
}

TEST(Wire, ReadsTheOtherLenses) {
  const auto ftheta = parsed<proto::CameraSpec>(
      Wire().message(2,
                     Wire()
                         .real64(1, 1)
                         .real64(2, 2)
                         .varint(3, 2)
                         .packed<double>(4, {3, 4})
                         .packed<double>(5, {5, 6, 7})
                         .real64(6, 8)
                         .message(7, Wire().real64(1, 9).real64(2, 10).real64(3, 11))));
  const auto& f = ftheta.ftheta_param();
  EXPECT_EQ(f.principal_point_x(), 1.0);
  EXPECT_EQ(f.principal_point_y(), 2.0);
  EXPECT_EQ(f.reference_poly(), proto::FthetaCameraParam::ANGLE_TO_PIXELDIST);
  EXPECT_EQ(f.pixeldist_to_angle_poly(1), 4.0);
  EXPECT_EQ(f.angle_to_pixeldist_poly(2), 7.0);
  EXPECT_EQ(f.max_angle(), 8.0);
  EXPECT_EQ(f.linear_cde().linear_c(), 9.0);
  EXPECT_EQ(f.linear_cde().linear_d(), 10.0);
  EXPECT_EQ(f.linear_cde().linear_e(), 11.0);
  const auto fisheye = parsed<proto::CameraSpec>(Wire().message(4,
                                                                Wire()
                                                                    .real64(1, 1)
                                                                    .real64(2, 2)
                                                                    .real64(3, 3)
                                                                    .real64(4, 4)
                                                                    .packed<double>(5, {5, 6, 7, 8})
                                                                    .real64(6, 9)));
  const auto& e = fisheye.opencv_fisheye_param();
  EXPECT_EQ(e.principal_point_y(), 2.0);
  EXPECT_EQ(e.focal_length_x(), 3.0);
  EXPECT_EQ(e.focal_length_y(), 4.0);
  EXPECT_EQ(e.radial_coeffs(3), 8.0);
  EXPECT_EQ(e.max_angle(), 9.0);
}

TEST(Wire, ReadsARequestForASweepAndABatch) {
  const Wire filter = Wire().real32(1, 0.25F).real32(2, 0.75F).varint(3, 1).real32(4, 0.5F);
  const auto lidar = parsed<proto::LidarRenderRequest>(Wire()
                                                           .text(1, "drive")
                                                           .message(2, Wire().varint(2, 1))
                                                           .fixed64(3, 7)
                                                           .fixed64(4, 8)
                                                           .message(5, pair_wire(1))
                                                           .message(6, object_wire())
                                                           .message(7, filter));
  EXPECT_EQ(lidar.scene_id(), "drive");
  EXPECT_EQ(lidar.lidar_config().lidar_type(), proto::AT128);
  EXPECT_EQ(lidar.frame_start_us(), 7U);
  EXPECT_EQ(lidar.frame_end_us(), 8U);
  expect_pair(lidar.sensor_pose(), 1);
  expect_pair(lidar.dynamic_objects(0).pose_pair(), 100);
  EXPECT_EQ(lidar.render_filter().raydrop_threshold(), 0.25F);
  EXPECT_EQ(lidar.render_filter().opacity_threshold(), 0.75F);
  EXPECT_TRUE(lidar.render_filter().enable_distance_filter());
  EXPECT_EQ(lidar.render_filter().distance_filter_threshold(), 0.5F);
  const Wire one = Wire().text(1, "s").varint(2, 5);
  const auto batch =
      parsed<proto::BatchRGBRenderRequest>(Wire().message(1, Wire().text(1, "front").message(2, one)));
  EXPECT_EQ(batch.items(0).camera_name(), "front");
  EXPECT_EQ(batch.items(0).request().resolution_h(), 5U);
  const auto all =
      parsed<proto::AggregatedRenderRequest>(Wire().message(1, one).message(2, Wire().text(1, "l")));
  EXPECT_EQ(all.rgb_requests(0).scene_id(), "s");
  EXPECT_EQ(all.lidar_requests(0).scene_id(), "l");
  for (const int format : {0, 1, 2, 3, 4, 5, 6}) EXPECT_TRUE(proto::ImageFormat_IsValid(format));
  EXPECT_EQ(proto::JPEG, 2);
  EXPECT_EQ(proto::GLOBAL, 5);
  EXPECT_EQ(proto::ROLLING_LEFT_TO_RIGHT, 2);
  EXPECT_EQ(proto::PANDAR128, 0);
}

template <class Message>
void expect_bytes(const Message& message, const Wire& wire) {
  EXPECT_EQ(message.SerializeAsString(), wire.bytes());
}

TEST(Wire, WritesReplies) {
  proto::RGBRenderReturn picture;
  picture.set_image_bytes("abc");
  expect_bytes(picture, Wire().text(1, "abc"));

  proto::BatchRGBRenderReturn batch;
  auto& item = *batch.add_items();
  item.set_camera_name("front");
  *item.mutable_result() = picture;
  item.set_success(true);
  item.set_error_message("no");
  expect_bytes(batch,
               Wire().message(
                   1, Wire().text(1, "front").message(2, Wire().text(1, "abc")).varint(3, 1).text(4, "no")));

  proto::LidarRenderReturn sweep;
  sweep.add_point_xyzs(1.5F);
  sweep.add_point_intensities(0.5F);
  sweep.set_num_points(300);
  sweep.set_point_xyzs_buffer("xyz");
  sweep.set_point_intensities_buffer("i");
  sweep.add_point_ring_ids(5);
  sweep.set_point_ring_ids_buffer("r");
  expect_bytes(sweep,
               Wire()
                   .packed<float>(1, {1.5F})
                   .packed<float>(2, {0.5F})
                   .varint(3, 300)
                   .text(4, "xyz")
                   .text(5, "i")
                   .text(6, "\x05")
                   .text(7, "r"));

  proto::AggregatedRenderReturn all;
  *all.add_rgb_returns() = picture;
  all.add_lidar_returns()->set_num_points(3);
  all.set_driver_data("d");
  expect_bytes(all, Wire().message(1, Wire().text(1, "abc")).message(2, Wire().varint(3, 3)).text(3, "d"));
}

TEST(Wire, WritesWhatThereIs) {
  proto_common::VersionId version;
  version.set_version_id("v");
  version.set_git_hash("h");
  version.mutable_grpc_api_version()->set_major(1);
  version.mutable_grpc_api_version()->set_minor(2);
  version.mutable_grpc_api_version()->set_patch(3);
  expect_bytes(version,
               Wire().text(1, "v").text(2, "h").message(3, Wire().varint(1, 1).varint(2, 2).varint(3, 3)));

  proto_common::AvailableScenesReturn scenes;
  scenes.add_scene_ids("a");
  expect_bytes(scenes, Wire().text(1, "a"));

  proto::LoadedScenesReturn loaded;
  auto& entry = *loaded.add_scenes();
  entry.set_scene_id("a");
  entry.set_loaded_instance_count(2);
  entry.set_reusable_instance_count(3);
  loaded.set_loaded_instance_capacity(4);
  expect_bytes(loaded, Wire().message(1, Wire().text(1, "a").varint(2, 2).varint(3, 3)).varint(2, 4));

  proto::AvailableEgoMasksReturn masks;
  auto& mask = *masks.add_ego_mask_metadata()->mutable_ego_mask_id();
  mask.set_camera_logical_id("front");
  mask.set_rig_config_id("rig");
  expect_bytes(masks, Wire().message(1, Wire().message(1, Wire().text(1, "front").text(2, "rig"))));

  proto::AvailableCamerasReturn cameras;
  auto& camera = *cameras.add_available_cameras();
  camera.mutable_intrinsics()->set_logical_id("front");
  camera.mutable_rig_to_camera()->mutable_vec()->set_x(2);
  camera.set_logical_id("front");
  expect_bytes(cameras,
               Wire().message(1,
                              Wire()
                                  .message(1, Wire().text(5, "front"))
                                  .message(2, Wire().message(1, Wire().real32(1, 2)))
                                  .text(3, "front")));

  proto::AvailableTrajectoriesReturn trajectories;
  auto& trajectory = *trajectories.add_available_trajectories();
  trajectory.set_trajectory_idx(1);
  auto& pose = *trajectory.mutable_trajectory()->add_poses();
  pose.mutable_pose()->mutable_vec()->set_y(2);
  pose.set_timestamp_us(5);
  const Wire path =
      Wire().message(1, Wire().message(1, Wire().message(1, Wire().real32(2, 2))).fixed64(2, 5));
  expect_bytes(trajectories, Wire().message(1, Wire().varint(1, 1).message(2, path)));

  proto::AvailableDynamicObjectsReturn objects;
  auto& object = *objects.add_dynamic_objects();
  object.set_id("car");
  object.set_semantic_class("automobile");
  *object.mutable_trajectory() = trajectory.trajectory();
  object.mutable_object_size()->set_size_x(4);
  object.mutable_object_size()->set_size_y(2);
  object.mutable_object_size()->set_size_z(1);
  object.set_asset_id("asset");
  expect_bytes(objects,
               Wire().message(1,
                              Wire()
                                  .text(1, "car")
                                  .text(2, "automobile")
                                  .message(3, path)
                                  .message(4, Wire().real32(1, 4).real32(2, 2).real32(3, 1))
                                  .text(5, "asset")));
}

TEST(Wire, ReadsEditsAndTellsOfThem) {
  const Wire box = Wire().real32(1, 4).real32(2, 2).real32(3, 1);
  const Wire replace = Wire().text(1, "van").text(2, "car").message(3, box);
  const Wire insert = Wire().text(1, "second").text(2, "taxi").message(4, box).text(5, "car");
  const auto edits =
      parsed<proto::EditAssetsRequest>(Wire().text(1, "drive").message(2, replace).message(3, insert));
  EXPECT_EQ(edits.scene_id(), "drive");
  EXPECT_EQ(edits.replace(0).original_id(), "van");
  EXPECT_EQ(edits.replace(0).replacement_id(), "car");
  EXPECT_EQ(edits.replace(0).object_size().size_x(), 4.0F);
  EXPECT_EQ(edits.insert(0).id(), "second");
  EXPECT_EQ(edits.insert(0).asset_id(), "car");
  EXPECT_EQ(parsed<proto::RestoreModelParametersRequest>(Wire().text(1, "drive")).scene_id(), "drive");
  EXPECT_EQ(parsed<proto::ExternalAssetObjectsRequest>(Wire().text(1, "drive")).scene_id(), "drive");
  proto::EditAssetsResponse edited;
  edited.set_success(true);
  edited.set_message("no");
  expect_bytes(edited, Wire().varint(1, 1).text(2, "no"));
  proto::ExternalAssetObjectsReturn external;
  external.add_track_ids("second");
  expect_bytes(external, Wire().text(1, "second"));
  proto::ServerConfig config;
  (*config.mutable_server_config())["device"] = "gpu";
  expect_bytes(config, Wire().message(1, Wire().text(1, "device").text(2, "gpu")));
}

}  // namespace
}  // namespace simuli::serve
