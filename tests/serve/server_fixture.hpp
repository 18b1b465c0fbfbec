#pragma once
// A server of the small scene on loopback, and a client.
#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <gtest/gtest.h>
#include <memory>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "host/apps/serve/server/server.hpp"
#include "tests/serve/served_client.hpp"
#include "tests/serve/served_scene.hpp"

namespace simuli::serve {

using std::chrono::milliseconds;
using test::channel_to;
using test::NreService;
using test::NurecService;

class ServerTest : public test::Served {
 protected:
  void SetUp() override {
    test::Served::SetUp();
    start({});
  }
  void start(ServerOptions options) {
    options.port = 0;
    server_ = std::make_unique<Server>(*handlers_, options);
    channel_ = channel_to(server_->address());
    stub_ = NreService::NewStub(channel_);
  }
  /// A plain connection, of which the server is to survive anything.
  [[nodiscard]] int connection() const {
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(server_->port()));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    return socket;
  }
  /// Takes the device, and has it until `is_held` says no more.
  [[nodiscard]] std::jthread hold_device(const std::atomic<bool>& is_held) {
    const auto is_begun = std::make_shared<std::atomic<bool>>(false);
    std::jthread holder([this, &is_held, is_begun] {
      std::array<FrameJob, 1> job{
          FrameJob{scene_->cameras()[0], recorded_shot("front", 0.5, 0.5), [&](const Frame&) {
                     *is_begun = true;
                     while (is_held) std::this_thread::sleep_for(milliseconds(5));
                   }}};
      session_->render(*scene_, job);
    });
    while (!*is_begun) std::this_thread::sleep_for(milliseconds(5));
    return holder;
  }
  void expect_answers() const {
    grpc::ClientContext context;
    proto_common::VersionId version;
    const grpc::Status status = stub_->get_version(&context, {}, &version);
    EXPECT_TRUE(status.ok()) << status.error_message();
  }

  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<NreService::Stub> stub_;
};

}  // namespace simuli::serve
