// What clients do with a server beside asking for frames, and how the known ones ask.
#include <list>

#include "tests/serve/metrics_text.hpp"
#include "tests/serve/server_fixture.hpp"

namespace simuli::serve {
namespace {

/// The second picture of two, and a scene that there is not.
TEST_F(ServerTest, CountsWhatItDoes) {
  const auto request = picture_request("front", 0.5, 0.5);
  std::uint64_t bytes = 0;
  for (int i = 0; i < 2; ++i) {
    grpc::ClientContext context;
    proto::RGBRenderReturn reply;
    ASSERT_TRUE(stub_->render_rgb(&context, request, &reply).ok());
    bytes += reply.ByteSizeLong();
  }
  auto nowhere = request;
  nowhere.set_scene_id("nowhere");
  grpc::ClientContext context;
  proto::RGBRenderReturn reply;
  ASSERT_EQ(stub_->render_rgb(&context, nowhere, &reply).error_code(), grpc::NOT_FOUND);
  const test::MetricsText text(server_->metrics());
  const std::string call = "call=\"render_rgb\"";
  EXPECT_EQ(text.value("simuli_requests_total{" + call + ",status=\"OK\"}"), 2.0);
  EXPECT_EQ(text.value("simuli_requests_total{" + call + ",status=\"NOT_FOUND\"}"), 1.0);
  EXPECT_EQ(text.value("simuli_request_seconds_count{" + call + "}"), 3.0);
  EXPECT_EQ(text.value("simuli_reply_bytes_total{" + call + "}"), static_cast<double>(bytes));
  EXPECT_EQ(text.value("simuli_frames_total{result=\"rendered\"}"), 2.0);
  EXPECT_EQ(text.value("simuli_stage_seconds_count{stage=\"worker_wait\"}"), 3.0);
  for (const char* const stage : {"device_wait", "rendering", "encoding"}) {
    EXPECT_EQ(text.value(std::string("simuli_stage_seconds_count{stage=\"") + stage + "\"}"), 2.0) << stage;
  }
  EXPECT_EQ(text.value("simuli_scene_loads_total"), 1.0);
  EXPECT_GE(text.value("simuli_scene_hits_total"), 2.0);
  EXPECT_EQ(text.value("simuli_scene_evictions_total"), 0.0);
  EXPECT_EQ(text.value("simuli_scenes_kept"), 1.0);
  EXPECT_EQ(text.value("simuli_requests_waiting"), 0.0);
  EXPECT_EQ(text.value("simuli_device_memory_bytes"), static_cast<double>(session_->device().memory().now));
  EXPECT_GT(text.value("simuli_device_memory_limit_bytes"), text.value("simuli_device_memory_peak_bytes"));
}

/// 1 MiB of nothing packs into a thousandth: what it would become is not made.
TEST_F(ServerTest, PackedRequestsAreRefused) {
  auto request = picture_request("front", 0.5, 0.5);
  request.set_scene_id(std::string(std::size_t{1} << 20U, 'x'));
  for (const grpc_compression_algorithm how : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
    grpc::ClientContext context;
    context.set_compression_algorithm(how);
    proto::RGBRenderReturn reply;
    EXPECT_EQ(stub_->render_rgb(&context, request, &reply).error_code(), grpc::UNIMPLEMENTED);
  }
  expect_answers();
}

/// Clients that ask and never read: their replies fill the windows of their connections.
class Unread {
 public:
  Unread(const std::string& address, const proto::RGBRenderRequest& request, int count)
      : stub_(narrow(address)), calls_(static_cast<std::size_t>(count)) {
    for (Call& call : calls_) {
      call.stream =
          stub_.PrepareCall(&call.context, "/nre.grpc.protos.sensorsim.SensorsimService/render_rgb", &queue_);
      call.stream->StartCall(&call);
      wait();
      const grpc::Slice slice(request.SerializeAsString());
      call.stream->WriteLast(grpc::ByteBuffer(&slice, 1), {}, &call);
      wait();
    }
  }
  ~Unread() {
    for (Call& call : calls_) {
      call.context.TryCancel();
      call.stream->Finish(&call.status, &call);
      wait();
    }
  }

 private:
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream;
    grpc::Status status;
  };
  /// Whose windows stay as they are.
  static std::shared_ptr<grpc::Channel> narrow(const std::string& address) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  }
  void wait() {
    void* tag = nullptr;
    bool is_ok = false;
    queue_.Next(&tag, &is_ok);
  }
  grpc::GenericStub stub_;
  grpc::CompletionQueue queue_;
  std::list<Call> calls_;
};

TEST_F(ServerTest, GivesUpRepliesThatNobodyReads) {
  auto request = picture_request("front", 0.5, 0.5);
  request.set_resolution_w(640);
  request.set_resolution_h(480);
  const auto unread = [&] { return test::MetricsText(server_->metrics()).value("simuli_replies_unread"); };
  const auto wait_until = [&](const std::function<bool()>& is_so) {
    for (int i = 0; i < 2000; ++i) {
      if (is_so()) return;  // asked once: replies go on being given up
      std::this_thread::sleep_for(milliseconds(5));
    }
    ADD_FAILURE() << unread() << " replies unread";
  };
  struct Case {
    const char* name;
    ReplyLimits limits;
    double kept;  // at last
  };
  const std::size_t of_one = 640U * 480U * 3U;
  for (const Case& of : {Case{"patience", {.patience = milliseconds(300)}, 0.0},
                         Case{"count", {.hurried = milliseconds(100), .most = 2}, 2.0},
                         Case{"bytes", {.hurried = milliseconds(100), .most_bytes = 4 * of_one}, 3.0}}) {
    SCOPED_TRACE(of.name);
    ServerOptions options;
    options.replies = of.limits;
    start(options);
    {
      const Unread clients(server_->address(), request, 6);
      wait_until([&] { return unread() > 0.0; });
      wait_until([&] {
        return unread() == of.kept &&
               test::MetricsText(server_->metrics())
                       .value("simuli_requests_total{call=\"render_rgb\",status=\"OK\"}") >= 6.0;
      });
      expect_answers();
    }
    wait_until([&] { return unread() == 0.0; });  // who reads takes all of it; who goes leaves nothing
    grpc::ClientContext context;
    proto::RGBRenderReturn reply;
    EXPECT_TRUE(stub_->render_rgb(&context, request, &reply).ok());
    EXPECT_EQ(reply.image_bytes().size(), of_one);
  }
}

TEST_F(ServerTest, EditsUnderBothNames) {
  handlers_ = std::make_unique<Handlers>(
      *session_, EgoMasks(), "", HandlerOptions{.allows_edits = true, .reported = {{"max-workers", "4"}}});
  start({});
  const auto nurec = NurecService::NewStub(channel_);
  proto::EditAssetsRequest edits;
  edits.set_scene_id("small");
  edits.add_insert()->set_id("second");
  edits.mutable_insert(0)->set_asset_id("car");
  grpc::ClientContext c1, c2, c3, c4, c5, c6;
  proto::EditAssetsResponse edited;
  ASSERT_TRUE(stub_->edit_assets(&c1, edits, &edited).ok());
  EXPECT_TRUE(edited.success()) << edited.message();
  ASSERT_TRUE(nurec->edit_assets(&c2, edits, &edited).ok());
  EXPECT_FALSE(edited.success());  // it is there
  proto::ExternalAssetObjectsRequest external_of;
  external_of.set_scene_id("small");
  proto::ExternalAssetObjectsReturn external;
  ASSERT_TRUE(nurec->get_external_asset_objects(&c3, external_of, &external).ok());
  EXPECT_EQ(external.track_ids_size(), 1);
  proto::RestoreModelParametersRequest restore;
  restore.set_scene_id("small");
  proto_common::Empty empty;
  ASSERT_TRUE(nurec->restore_model_parameters(&c4, restore, &empty).ok());
  external.Clear();
  ASSERT_TRUE(stub_->get_external_asset_objects(&c5, external_of, &external).ok());
  EXPECT_EQ(external.track_ids_size(), 0);
  proto::ServerConfig config;
  ASSERT_TRUE(nurec->get_server_config(&c6, {}, &config).ok());
  EXPECT_EQ(config.server_config().at("max-workers"), "4");
  EXPECT_EQ(config.server_config().at("enable-editing-actors"), "true");
  EXPECT_FALSE(config.server_config().at("device").empty());
}

TEST_F(ServerTest, ShutsDownWhereThatIsAllowed) {
  proto_common::Empty empty;
  grpc::ClientContext c1, c2;
  const grpc::Status denied = stub_->shut_down(&c1, {}, &empty);
  EXPECT_EQ(denied.error_code(), grpc::PERMISSION_DENIED);
  EXPECT_NE(denied.error_message().find("--allow-shut-down"), std::string::npos);
  EXPECT_FALSE(server_->is_shut_down_requested());
  ServerOptions options;
  options.allows_shut_down = true;
  start(options);
  EXPECT_TRUE(NurecService::NewStub(channel_)->shut_down(&c2, {}, &empty).ok());
  EXPECT_TRUE(server_->is_shut_down_requested());
  expect_answers();  // until its owner drains it
}

/// Addresses in a list, as simulators take them: calls go to one after the other, and all answer alike.
TEST_F(ServerTest, ReplicasAreAListOfAddresses) {
  RenderSession second_session(options());
  const Handlers second_handlers(second_session, EgoMasks(), "0123abc");
  ServerOptions second_options;
  second_options.port = 0;
  const Server second(second_handlers, second_options);
  grpc::ChannelArguments in_turns;
  in_turns.SetLoadBalancingPolicyName("round_robin");
  const auto channel = grpc::CreateCustomChannel(
      "ipv4:" + server_->address() + "," + second.address(), grpc::InsecureChannelCredentials(), in_turns);
  ASSERT_TRUE(channel->WaitForConnected(std::chrono::system_clock::now() + std::chrono::seconds(10)));
  const auto stub = NreService::NewStub(channel);
  const auto request = picture_request("front", 0.5, 0.5);
  const std::string wanted = rendered(request);
  const auto answered = [](const std::string& metrics) {
    const std::string sample = "simuli_requests_total{call=\"render_rgb\",status=\"OK\"}";
    const test::MetricsText text(metrics);
    return text.has(sample) ? text.value(sample) : 0.0;
  };
  int requested = 0;
  for (; requested < 200 && (answered(server_->metrics()) < 2.0 || answered(second.metrics()) < 2.0);
       ++requested) {
    grpc::ClientContext context;
    proto::RGBRenderReturn reply;
    ASSERT_TRUE(stub->render_rgb(&context, request, &reply).ok());
    EXPECT_EQ(reply.image_bytes(), wanted);
  }
  EXPECT_EQ(answered(server_->metrics()) + answered(second.metrics()), requested);
  EXPECT_GE(answered(second.metrics()), 2.0);
}

/// The camera as it was told, at a share of its size, the frame a microsecond long and the same pose at both
/// ends; a sweep likewise, with a filter.
TEST_F(ServerTest, AsCarlasClientAsks) {
  proto::AvailableCamerasRequest of_scene;
  of_scene.set_scene_id("small");
  proto::AvailableCamerasReturn cameras;
  grpc::ClientContext c1, c2, c3, c4;
  ASSERT_TRUE(stub_->get_available_cameras(&c1, of_scene, &cameras).ok());
  proto::BatchRGBRenderRequest batch;
  for (const auto& camera : cameras.available_cameras()) {
    if (camera.intrinsics().camera_param_case() == proto::CameraSpec::CAMERA_PARAM_NOT_SET) continue;
    auto request = picture_request(camera.logical_id(), 0.5, 0.5);
    *request.mutable_camera_intrinsics() = camera.intrinsics();
    request.set_resolution_w(camera.intrinsics().resolution_w() / 4);
    request.set_resolution_h(camera.intrinsics().resolution_h() / 4);
    request.set_frame_end_us(request.frame_start_us() + 1);
    request.set_image_quality(95);
    batch.add_items()->set_camera_name(camera.logical_id());
    *batch.mutable_items()->rbegin()->mutable_request() = request;
  }
  ASSERT_EQ(batch.items_size(), 4);
  proto::BatchRGBRenderReturn reply;
  ASSERT_TRUE(stub_->batch_render_rgb(&c2, batch, &reply).ok());
  for (int i = 0; i < reply.items_size(); ++i) {
    const auto& request = batch.items(i).request();
    EXPECT_TRUE(reply.items(i).success()) << reply.items(i).error_message();
    EXPECT_EQ(reply.items(i).camera_name(), batch.items(i).camera_name());
    EXPECT_EQ(reply.items(i).result().image_bytes().size(),
              std::size_t{3} * request.resolution_w() * request.resolution_h());
    EXPECT_EQ(reply.items(i).result().image_bytes(), rendered(request));
  }
  auto sweep = sweep_request(0.5, 0.5);
  sweep.set_frame_end_us(sweep.frame_start_us() + 1);
  sweep.mutable_lidar_config()->set_lidar_type(proto::PANDAR128);
  proto::LidarRenderReturn points;
  ASSERT_TRUE(stub_->render_lidar(&c3, sweep, &points).ok());
  EXPECT_GT(points.num_points(), 0U);
  EXPECT_EQ(points.point_xyzs_buffer().size(), 12U * points.num_points());
  EXPECT_EQ(points.point_intensities_buffer().size(), 4U * points.num_points());
  sweep.mutable_render_filter()->set_enable_distance_filter(true);
  EXPECT_EQ(stub_->render_lidar(&c4, sweep, &points).error_code(), grpc::UNIMPLEMENTED);
}

}  // namespace
}  // namespace simuli::serve
