// simuli serve, beside simuli render.
#include <Eigen/Core>  // before the macros of the HTTP library
#include <csignal>
#include <cstdlib>
#include <gtest/gtest.h>
#ifdef SIMULI_HAS_METRICS
#include <httplib.h>
#endif

#include "io/base/file.hpp"
#include "tests/cli/background_program.hpp"
#include "tests/cli/cli_fixture.hpp"
#include "tests/serve/metrics_text.hpp"
#include "tests/serve/served_client.hpp"
#include "tests/serve/served_scene.hpp"

namespace simuli::test {
namespace {

class ServeCli : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    write_scene(folder_ / "small.scene", served_file());
  }
  void start(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{
        SIMULI_PROGRAM, "serve", (folder_ / "small.scene").string(), "--port", "0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    server_ = std::make_unique<BackgroundProgram>(arguments, folder_ / "serve.txt");
    const int port = server_->disoccluded_number("127.0.0.1:");
    ASSERT_GT(port, 0) << server_->output();
    channel_ = channel_to(fmt::format("127.0.0.1:{}", port));
    stub_ = NreService::NewStub(channel_);
  }
  std::unique_ptr<BackgroundProgram> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<NreService::Stub> stub_;
};

/// A client that knows nothing of the scene but what the server tells.
TEST_F(ServeCli, GivesThePictureOfRender) {
  start();
  serve::proto::AvailableCamerasRequest of_scene;
  of_scene.set_scene_id("small");
  grpc::ClientContext c1, c2, c3, c4;
  serve::proto::AvailableCamerasReturn cameras;
  ASSERT_TRUE(stub_->get_available_cameras(&c1, of_scene, &cameras).ok());
  serve::proto::AvailableTrajectoriesRequest path_of;
  path_of.set_scene_id("small");
  serve::proto::AvailableTrajectoriesReturn paths;
  ASSERT_TRUE(stub_->get_available_trajectories(&c2, path_of, &paths).ok());
  serve::proto::AvailableDynamicObjectsRequest objects_of;
  objects_of.set_scene_id("small");
  serve::proto::AvailableDynamicObjectsReturn objects;
  ASSERT_TRUE(stub_->get_dynamic_objects(&c3, objects_of, &objects).ok());

  const serve::proto_common::PoseAtTime& rig = paths.available_trajectories(0).trajectory().poses(0);
  const serve::proto::AvailableCamera& camera = cameras.available_cameras(0);
  const Pose local_from_camera =
      serve::pose_of(rig.pose(), "rig") * serve::pose_of(camera.rig_to_camera(), "camera");
  serve::proto::RGBRenderRequest request;
  request.set_scene_id("small");
  request.set_resolution_w(camera.intrinsics().resolution_w());
  request.set_resolution_h(camera.intrinsics().resolution_h());
  *request.mutable_camera_intrinsics() = camera.intrinsics();
  request.set_frame_start_us(rig.timestamp_us());
  request.set_frame_end_us(rig.timestamp_us());
  *request.mutable_sensor_pose()->mutable_start_pose() = serve::message_of(local_from_camera);
  *request.mutable_sensor_pose()->mutable_end_pose() = serve::message_of(local_from_camera);
  for (const auto& object : objects.dynamic_objects()) {
    auto& actor = *request.add_dynamic_objects();
    actor.set_track_id(object.id());
    *actor.mutable_pose_pair()->mutable_start_pose() = object.trajectory().poses(0).pose();
    *actor.mutable_pose_pair()->mutable_end_pose() = object.trajectory().poses(0).pose();
  }
  request.set_image_format(serve::proto::PNG);
  serve::proto::RGBRenderReturn reply;
  const grpc::Status status = stub_->render_rgb(&c4, request, &reply);
  ASSERT_TRUE(status.ok()) << status.error_message();
  const Outcome render = run("render small.scene --sensor front --times 0:0:1 --duration 0 -o frames");
  ASSERT_EQ(render.exit_code, 0) << render.err;
  EXPECT_EQ(reply.image_bytes(), read_file(folder_ / "frames" / "front_000000.png"));
}

TEST_F(ServeCli, DrainsAndEndsBySigterm) {
  start();
  EXPECT_EQ(health_of(channel_, ""), 1);
  EXPECT_EQ(server_->end_by(SIGTERM), 0);
  EXPECT_NE(server_->output().find("running requests are finished"), std::string::npos) << server_->output();
}

TEST_F(ServeCli, EndsByAClientWhereThatIsAllowed) {
  start({"--allow-shut-down"});
  grpc::ClientContext context;
  serve::proto_common::Empty empty;
  ASSERT_TRUE(stub_->shut_down(&context, {}, &empty).ok());
  EXPECT_EQ(server_->end_by(0), 0) << server_->output();
}

TEST_F(ServeCli, ListensElsewhereOnRequestAlone) {
  expect_failure("serve small.scene --host 0.0.0.0", kUsage, "--host: found 0.0.0.0 without TLS");
  expect_failure("serve nowhere.scene", kInput, "nowhere.scene");
  expect_failure("serve small.scene a/small.scene", kUsage, "two named \"small\"");
  expect_failure("serve small.scene --egocar-hood-dir none", kInput, "none");
  expect_failure("serve small.scene --tls-cert x.pem", kUsage, "--tls-cert");
  expect_failure("serve small.scene --host 203.0.113.7 --insecure", kUsage, "found 203.0.113.7:8080");
}

#ifdef SIMULI_HAS_METRICS
TEST_F(ServeCli, TellsPrometheus) {
  start({"--metrics-port", "0"});
  const int port = server_->disoccluded_number("http://127.0.0.1:");
  ASSERT_GT(port, 0) << server_->output();
  EXPECT_EQ(health_of(channel_, ""), 1);
  httplib::Client client("127.0.0.1", port);
  const auto reply = client.Get("/metrics");
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 200);
  EXPECT_EQ(reply->get_header_value("Content-Type"), "text/plain; version=0.0.4; charset=utf-8");
  EXPECT_EQ(MetricsText(reply->body).value("simuli_scene_loads_total"), 1.0);
  EXPECT_EQ(client.Get("/")->status, 404);
  EXPECT_EQ(client.Get("/metrics", {{"Host", "elsewhere.example"}})->status, 403);
  expect_failure(
      fmt::format("serve small.scene --port 0 --metrics-port {}", port), kUsage, "--metrics-port: found");
  EXPECT_EQ(server_->end_by(SIGTERM), 0);
}
#endif

TEST_F(ServeCli, SpeaksTls) {
  if (std::system("openssl version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no openssl";
  const std::string make = fmt::format(
      "cd '{}' && openssl req -x509 -newkey rsa:2048 -nodes -keyout key.pem -out cert.pem -days 2 -subj "
      "/CN=localhost "
      "-addext subjectAltName=DNS:localhost,IP:127.0.0.1 > /dev/null 2>&1",
      folder_.string());
  ASSERT_EQ(std::system(make.c_str()), 0);
  start({"--tls-cert", (folder_ / "cert.pem").string(), "--tls-key", (folder_ / "key.pem").string()});
  EXPECT_LT(health_of(channel_, ""), 0);  // plain text
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = read_file(folder_ / "cert.pem");
  const std::string address = fmt::format("127.0.0.1:{}", server_->disoccluded_number("127.0.0.1:"));
  EXPECT_EQ(health_of(grpc::CreateChannel(address, grpc::SslCredentials(options)), ""), 1);
#ifdef SIMULI_HAS_METRICS
  start({"--tls-cert",
         (folder_ / "cert.pem").string(),
         "--tls-key",
         (folder_ / "key.pem").string(),
         "--host",
         "0.0.0.0",
         "--insecure",
         "--metrics-port",
         "0"});
  EXPECT_GT(server_->disoccluded_number("http://127.0.0.1:"), 0)
      << server_->output();  // plain: not on the network
#endif
}

}  // namespace
}  // namespace simuli::test
