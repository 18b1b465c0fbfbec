// The service over loopback.
#include "tests/host/expect_error.hpp"
#include "tests/serve/metrics_text.hpp"
#include "tests/serve/server_fixture.hpp"

namespace simuli::serve {
namespace {

TEST_F(ServerTest, AnswersWhatThereIs) {
  proto_common::VersionId version;
  grpc::ClientContext c1, c2, c3, c4, c5, c6, c7;
  ASSERT_TRUE(stub_->get_version(&c1, {}, &version).ok());
  EXPECT_EQ(version.version_id().rfind("simuli ", 0), 0U);
  EXPECT_EQ(version.git_hash(), "0123abc");
  EXPECT_TRUE(version.has_grpc_api_version());
  proto_common::AvailableScenesReturn scenes;
  ASSERT_TRUE(stub_->get_available_scenes(&c2, {}, &scenes).ok());
  ASSERT_EQ(scenes.scene_ids_size(), 1);
  EXPECT_EQ(scenes.scene_ids(0), "small");
  proto::LoadedScenesReturn loaded;
  ASSERT_TRUE(stub_->get_loaded_scenes(&c3, {}, &loaded).ok());
  EXPECT_EQ(loaded.scenes(0).scene_id(), "small");
  EXPECT_EQ(loaded.loaded_instance_capacity(), 4U);
  proto::AvailableCamerasRequest of_scene;
  of_scene.set_scene_id("small");
  proto::AvailableCamerasReturn cameras;
  ASSERT_TRUE(stub_->get_available_cameras(&c4, of_scene, &cameras).ok());
  ASSERT_EQ(cameras.available_cameras_size(), 5);
  const proto::AvailableCamera& front = cameras.available_cameras(0);
  EXPECT_EQ(front.logical_id(), "front");
  EXPECT_EQ(front.intrinsics().SerializeAsString(), spec_of(file_.cameras[0].model).SerializeAsString());
  EXPECT_EQ(front.rig_to_camera().vec().x(), 1.5F);  // where it is on the rig, not the rig seen from it
  EXPECT_EQ(front.rig_to_camera().quat().x(), -0.5F);
  proto::AvailableEgoMasksReturn masks;
  ASSERT_TRUE(stub_->get_available_ego_masks(&c5, {}, &masks).ok());
  EXPECT_EQ(masks.ego_mask_metadata_size(), 0);
  proto::AvailableDynamicObjectsRequest objects_of;
  objects_of.set_scene_id("small");
  proto::AvailableDynamicObjectsReturn objects;
  ASSERT_TRUE(stub_->get_dynamic_objects(&c6, objects_of, &objects).ok());
  ASSERT_EQ(objects.dynamic_objects_size(), 2);
  const proto::DynamicObjectTrack& van = objects.dynamic_objects(1);
  EXPECT_EQ(van.id(), "van");
  EXPECT_EQ(van.semantic_class(), "truck");
  EXPECT_EQ(van.object_size().size_z(), 2.5F);
  EXPECT_EQ(van.trajectory().poses(1).timestamp_us(), 2000000U);
  EXPECT_EQ(van.trajectory().poses(1).pose().vec().x(), 12.0F);
  EXPECT_EQ(van.trajectory().poses(1).pose().quat().z(), 1.0F);
  proto::AvailableTrajectoriesRequest path_of;
  path_of.set_scene_id("small");
  proto::AvailableTrajectoriesReturn path;
  ASSERT_TRUE(stub_->get_available_trajectories(&c7, path_of, &path).ok());
  EXPECT_EQ(path.available_trajectories(0).trajectory().poses_size(), 3);
}

TEST_F(ServerTest, RendersUnderBothNames) {
  const auto request = picture_request("rolling", 0.5, 0.75);
  const std::string wanted = rendered(request);
  const auto nurec = NurecService::NewStub(channel_);
  grpc::ClientContext c1, c2, c3, c4, c5;
  proto::RGBRenderReturn one, two;
  ASSERT_TRUE(stub_->render_rgb(&c1, request, &one).ok());
  ASSERT_TRUE(nurec->render_rgb(&c2, request, &two).ok());
  EXPECT_EQ(one.image_bytes(), wanted);
  EXPECT_EQ(two.image_bytes(), wanted);
  const auto sweep = sweep_request(0.5, 0.625);
  proto::LidarRenderReturn points;
  c3.AddMetadata("x-simuli-lidar", "top");
  ASSERT_TRUE(stub_->render_lidar(&c3, sweep, &points).ok());
  EXPECT_EQ(points.SerializeAsString(), rendered(sweep).SerializeAsString());
  proto::BatchRGBRenderRequest batch;
  *batch.add_items()->mutable_request() = request;
  proto::BatchRGBRenderReturn items;
  ASSERT_TRUE(stub_->batch_render_rgb(&c4, batch, &items).ok());
  EXPECT_EQ(items.items(0).result().image_bytes(), wanted);
  proto::AggregatedRenderRequest all;
  *all.add_rgb_requests() = request;
  proto::AggregatedRenderReturn both;
  ASSERT_TRUE(stub_->render_aggregated(&c5, all, &both).ok());
  EXPECT_EQ(both.rgb_returns(0).image_bytes(), wanted);
}

TEST_F(ServerTest, FourClientsGetWhatOneGets) {
  const std::vector<proto::RGBRenderRequest> requests{picture_request("front", 0.5, 0.5),
                                                      picture_request("rolling", 0.25, 0.5),
                                                      picture_request("fisheye", 1.0, 1.0, proto::PNG),
                                                      picture_request("wide", 1.5, 1.5)};
  std::vector<std::string> alone;
  for (const auto& request : requests) alone.push_back(rendered(request));
  std::atomic<int> different = 0;
  {
    std::vector<std::jthread> clients;
    for (std::size_t k = 0; k < 4; ++k) {
      clients.emplace_back([&, k] {
        const auto stub = NreService::NewStub(channel_to(server_->address()));
        for (std::size_t round = 0; round < 8; ++round) {
          const std::size_t i = (k + round) % 4;
          grpc::ClientContext context;
          proto::RGBRenderReturn reply;
          const grpc::Status status = stub->render_rgb(&context, requests[i], &reply);
          if (!status.ok() || reply.image_bytes() != alone[i]) ++different;
        }
      });
    }
  }
  EXPECT_EQ(different, 0);
}

TEST_F(ServerTest, StatusesAreTheProtocols) {
  const auto status_of = [&](const std::function<void(proto::RGBRenderRequest&)>& spoil) {
    auto request = picture_request("front", 0.5, 0.5);
    spoil(request);
    grpc::ClientContext context;
    proto::RGBRenderReturn reply;
    return stub_->render_rgb(&context, request, &reply);
  };
  EXPECT_EQ(status_of([](auto& q) { q.set_scene_id("x"); }).error_code(), grpc::NOT_FOUND);
  EXPECT_EQ(status_of([](auto& q) { q.set_frame_end_us(90000000); }).error_code(), grpc::OUT_OF_RANGE);
  EXPECT_EQ(status_of([](auto& q) { q.set_image_format(proto::AVC); }).error_code(), grpc::UNIMPLEMENTED);
  const grpc::Status huge = status_of([](auto& q) {
    q.set_resolution_w(100000);
    q.set_resolution_h(100000);
  });
  EXPECT_EQ(huge.error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_NE(huge.error_message().find("100000 x 100000 px"), std::string::npos);
  std::filesystem::remove_all(scratch_ / "small.scene");
  start({});
  scene_.reset();
  session_ = std::make_unique<RenderSession>(options());
  handlers_ = std::make_unique<Handlers>(*session_, EgoMasks(), "");
  start({});
  grpc::ClientContext context;
  proto::AvailableCamerasRequest request;
  request.set_scene_id("small");
  proto::AvailableCamerasReturn reply;
  EXPECT_EQ(stub_->get_available_cameras(&context, request, &reply).error_code(), grpc::FAILED_PRECONDITION);
}

TEST_F(ServerTest, WhatItLacksIsUnimplemented) {
  grpc::TemplatedGenericStub<proto_common::Empty, proto_common::Empty> stub(channel_);
  for (const char* const name : {"render_radar", "stream_rgb"}) {
    grpc::ClientContext context;
    grpc::CompletionQueue queue;
    proto_common::Empty reply;
    grpc::Status status;
    const auto call = stub.PrepareUnaryCall(
        &context, std::string("/nre.grpc.protos.sensorsim.SensorsimService/") + name, {}, &queue);
    call->StartCall();
    call->Finish(&reply, &status, nullptr);
    void* tag = nullptr;
    bool is_ok = false;
    queue.Next(&tag, &is_ok);
    EXPECT_EQ(status.error_code(), grpc::UNIMPLEMENTED) << name;
  }
}

TEST_F(ServerTest, RequestsHaveALargestSize) {
  auto request = picture_request("front", 0.5, 0.5);
  request.set_scene_id(std::string(Server::kLargestRequest, 'x'));
  grpc::ClientContext context;
  proto::RGBRenderReturn reply;
  EXPECT_EQ(stub_->render_rgb(&context, request, &reply).error_code(), grpc::RESOURCE_EXHAUSTED);
  expect_answers();
}

/// While the device is somebody's.
TEST_F(ServerTest, DeadlinesAndCancellationsAreHeard) {
  std::atomic<bool> is_held = true;
  std::jthread holder = hold_device(is_held);
  const auto request = picture_request("front", 0.5, 0.5);
  {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + milliseconds(200));
    proto::RGBRenderReturn reply;
    EXPECT_EQ(stub_->render_rgb(&context, request, &reply).error_code(), grpc::DEADLINE_EXCEEDED);
  }
  {
    grpc::ClientContext context;
    std::jthread canceller([&] {
      std::this_thread::sleep_for(milliseconds(100));
      context.TryCancel();
    });
    proto::RGBRenderReturn reply;
    EXPECT_EQ(stub_->render_rgb(&context, request, &reply).error_code(), grpc::CANCELLED);
  }
  is_held = false;
  holder.join();
  grpc::ClientContext context;
  proto::RGBRenderReturn reply;
  EXPECT_TRUE(stub_->render_rgb(&context, request, &reply).ok());
}

TEST_F(ServerTest, MoreThanItsWorkersWait) {
  ServerOptions options;
  options.max_workers = 1;
  start(options);
  std::atomic<int> answered = 0;
  {
    std::vector<std::jthread> clients;
    for (int k = 0; k < 8; ++k) {
      clients.emplace_back([&, k] {
        const auto stub = NreService::NewStub(channel_to(server_->address()));
        grpc::ClientContext context;
        proto::RGBRenderReturn reply;
        const double time_s = 0.5 + 0.01 * k;  // none asks for another one's
        const grpc::Status status =
            stub->render_rgb(&context, picture_request("front", time_s, time_s), &reply);
        EXPECT_TRUE(status.ok()) << status.error_code() << ": " << status.error_message();
        if (status.ok()) ++answered;
      });
    }
  }
  EXPECT_EQ(answered, 8);
}

TEST_F(ServerTest, RendersWhatSeveralAskForOnce) {
  std::atomic<bool> is_held = true;
  std::jthread holder = hold_device(is_held);
  const auto counted = [&] { return test::MetricsText(server_->metrics()); };
  const double before = counted().value("simuli_frames_total{result=\"rendered\"}");
  const proto::RGBRenderRequest request = picture_request("front", 0.5, 0.5);
  std::atomic<int> right = 0;
  {
    std::vector<std::string> replies(6);
    {
      std::vector<std::jthread> clients;
      for (std::size_t k = 0; k < replies.size(); ++k) {
        clients.emplace_back([&, k] {
          const auto stub = NreService::NewStub(channel_to(server_->address()));
          grpc::ClientContext context;
          proto::RGBRenderReturn reply;
          if (stub->render_rgb(&context, request, &reply).ok()) replies[k] = reply.image_bytes();
        });
      }
      for (int i = 0; i < 6000 && counted().value("simuli_requests_shared") < 5.0; ++i) {
        std::this_thread::sleep_for(milliseconds(5));
      }
      is_held = false;
    }
    const std::string wanted = rendered(request);
    for (const std::string& reply : replies) right += reply == wanted ? 1 : 0;
  }
  EXPECT_EQ(right, 6);
  EXPECT_EQ(counted().value("simuli_requests_shared"), 5.0);
  // The holder's, theirs, and the one they are compared with.
  EXPECT_LE(counted().value("simuli_frames_total{result=\"rendered\"}"), before + 3.0);
}

TEST_F(ServerTest, TellsItsHealthAndDrains) {
  for (const char* const service :
       {"", "nre.grpc.protos.sensorsim.SensorsimService", "nurec.grpc.protos.sensorsim.SensorsimService"}) {
    EXPECT_EQ(test::health_of(channel_, service), 1) << service;
  }
  EXPECT_EQ(test::health_of(channel_, "another"), -static_cast<int>(grpc::NOT_FOUND));
  std::atomic<bool> is_held = true;
  std::jthread holder = hold_device(is_held);
  grpc::Status status;
  proto::RGBRenderReturn reply;
  std::jthread client([&] {
    grpc::ClientContext context;
    status = stub_->render_rgb(&context, picture_request("front", 0.5, 0.5), &reply);
  });
  std::this_thread::sleep_for(milliseconds(200));  // until it waits for the device
  std::jthread opener([&] {
    std::this_thread::sleep_for(milliseconds(200));
    is_held = false;
  });
  server_->drain(std::chrono::seconds(20));
  client.join();
  EXPECT_TRUE(status.ok()) << status.error_message();  // it had begun
  EXPECT_EQ(reply.image_bytes(), rendered(picture_request("front", 0.5, 0.5)));
  EXPECT_LT(test::health_of(channel_to(server_->address()), ""), 0);
}

/// The beginning of HTTP/2: the preface, and settings.
std::string greeting() {
  return "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + std::string("\x00\x00\x00\x04\x00\x00\x00\x00\x00", 9);
}
/// A frame of HTTP/2 on the first stream.
std::string http2_frame(char type, char flags, const std::string& payload) {
  const auto byte = [&](unsigned shift) { return static_cast<char>(payload.size() >> shift & 0xFFU); };
  return std::string{byte(16), byte(8), byte(0), type, flags, 0, 0, 0, 1} + payload;
}

TEST_F(ServerTest, DrainsWithoutClientsThatAreDead) {
  const int dead = connection();  // hears nothing, and answers no ping
  ASSERT_GT(::send(dead, greeting().data(), greeting().size(), MSG_NOSIGNAL), 0);
  expect_answers();
  const auto begin = std::chrono::steady_clock::now();
  server_->drain(std::chrono::seconds(60));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  ::close(dead);
}

TEST_F(ServerTest, WaitsForNoRequestForEver) {
  ServerOptions options;
  options.connection_age = milliseconds(200);
  start(options);
  std::string headers;  // literals, without compression
  for (const auto& [name, value] : {std::pair<std::string, std::string>{":method", "POST"},
                                    {":scheme", "http"},
                                    {":path", "/nre.grpc.protos.sensorsim.SensorsimService/render_rgb"},
                                    {":authority", "localhost"},
                                    {"content-type", "application/grpc"},
                                    {"te", "trailers"}}) {
    headers += std::string(1, 0) + static_cast<char>(name.size()) + name;
    headers += static_cast<char>(value.size()) + value;
  }
  const std::string body("\x00\x00\x10\x00\x00half", 9);  // 1 MiB, it says
  const std::string said = greeting() + http2_frame(1, 4, headers) + http2_frame(0, 0, body);
  const int socket = connection();
  ASSERT_GT(::send(socket, said.data(), said.size(), MSG_NOSIGNAL), 0);
  const timeval patience{10, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  std::array<char, 256> heard{};
  ssize_t bytes = 1;
  while (bytes > 0) bytes = ::recv(socket, heard.data(), heard.size(), 0);
  EXPECT_TRUE(bytes == 0 || errno == ECONNRESET) << errno;
  ::close(socket);
  expect_answers();
}

TEST_F(ServerTest, SurvivesConnectionsThatAreNone) {
  std::vector<int> idle;
  for (int i = 0; i < 500; ++i) idle.push_back(connection());
  const std::string preface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
  // Half a preface; frames that are cut off, too long, of no kind; another protocol.
  for (const std::string& said :
       {preface.substr(0, 10),
        preface + std::string("\x00\x00\x12\x04\x00", 5),
        preface + std::string("\xFF\xFF\xFF\x00\x01\x00\x00\x00\x01", 9) + std::string(100, 'x'),
        preface + std::string("\x00\x00\x01\x77\xFF\xFF\xFF\xFF\xFF", 9) + "x",
        std::string("GET / HTTP/1.1\r\n\r\n"),
        std::string(5000, '\x00')}) {
    const int socket = connection();
    static_cast<void>(!::send(socket, said.data(), said.size(), MSG_NOSIGNAL));
    ::close(socket);
    expect_answers();
  }
  expect_answers();
  for (const int socket : idle) ::close(socket);
}

TEST_F(ServerTest, APortIsOneServers) {
  ServerOptions options;
  options.port = server_->port();
  expect_error(ErrorKind::kUsage, "--port", [&] { Server second(*handlers_, options); });
  options.port = 0;
  options.tls_certificate = "cert.pem";
  expect_error(ErrorKind::kUsage, "--tls-cert", [&] { Server half(*handlers_, options); });
  options.tls_key = (scratch_ / "none.pem").string();
  expect_error(ErrorKind::kInput, "none.pem", [&] { Server without(*handlers_, options); });
  options.tls_key = options.tls_certificate = scratch_.file("bad.pem", "no certificate").string();
  expect_error(ErrorKind::kUsage, "TLS files", [&] { Server bad(*handlers_, options); });
}

}  // namespace
}  // namespace simuli::serve
