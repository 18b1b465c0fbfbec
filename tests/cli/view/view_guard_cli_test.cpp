// The viewer and those who mean it harm: pages of other sites, and clients that keep it waiting.
#include <Eigen/Core>  // before the macros of the HTTP library
#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <httplib.h>
#include <memory>
#include <netinet/in.h>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "tests/cli/view/view_fixture.hpp"

namespace {

using namespace simuli::test;

TEST_F(ViewCli, OtherSitesGetNothing) {
  make_street_scene(3);
  start();
  const std::string own = "http://127.0.0.1:" + std::to_string(port_);
  const auto status = [&](const httplib::Headers& headers) {
    return post("/api/picture", view_of("front").dump(), headers).status;
  };
  EXPECT_EQ(status({{"Origin", own}, {"Sec-Fetch-Site", "same-origin"}}), 200);
  for (const char* origin : {"http://localhost:9107", "https://example.org", "null"}) {
    EXPECT_EQ(status({{"Origin", origin}}), 403) << origin;
  }
  for (const char* site : {"cross-site", "same-site"})
    EXPECT_EQ(status({{"Sec-Fetch-Site", site}}), 403) << site;
  EXPECT_EQ(client_->Get("/api/scene", {{"Sec-Fetch-Site", "cross-site"}})->status, 403);
  for (const char* path : {"/api/add?file=a.ply&time_s=0", "/api/duplicate"}) {
    EXPECT_EQ(post(path, std::string("{}"), {{"Sec-Fetch-Site", "cross-site"}}).status, 403) << path;
  }
  // A link on another site's page leads here all the same.
  EXPECT_EQ(client_->Get("/", {{"Sec-Fetch-Site", "cross-site"}})->status, 200);
  EXPECT_EQ(client_->Get("/", {{"Host", "[::1].evil.org"}})->status, 403);
  EXPECT_EQ(client_->Get("/", {{"Host", "127.0.0.1:evil.org"}})->status, 403);
}

/// A connection that begins a request and does not end it.
class SlowClient {
 public:
  explicit SlowClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_open_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  SlowClient(const SlowClient&) = delete;
  SlowClient& operator=(const SlowClient&) = delete;
  ~SlowClient() { ::close(socket_); }
  void send(const std::string& text) const {
    if (is_open_) static_cast<void>(::send(socket_, text.data(), text.size(), MSG_NOSIGNAL));
  }

 private:
  int socket_;
  bool is_open_;
};

TEST_F(ViewCli, SlowAndIdleClientsDelayNobody) {
  make_street_scene(3);
  start();
  const auto seconds = [&] {
    const auto begin = std::chrono::steady_clock::now();
    httplib::Client client("127.0.0.1", port_);
    client.set_read_timeout(30);
    const httplib::Result reply = client.Get("/api/status");
    EXPECT_TRUE(reply && reply->status == 200);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  constexpr double kSoon_s = 3.0;  // also where everything is slower
  std::vector<std::unique_ptr<SlowClient>> clients;
  for (int i = 0; i < 200; ++i) {
    clients.push_back(std::make_unique<SlowClient>(port_));
    if (i % 2 == 0) clients.back()->send("POST /api/picture HTTP/1.1\r\nHost: ");
  }
  EXPECT_LT(seconds(), kSoon_s);
  // As many as there are threads, each with a byte now and then.
  clients.clear();
  for (int i = 0; i < 60; ++i) clients.push_back(std::make_unique<SlowClient>(port_));
  std::atomic<bool> is_over = false;
  std::thread trickle([&] {
    while (!is_over) {
      for (const auto& client : clients) client->send("G");
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  });
  EXPECT_LT(seconds(), kSoon_s);
  EXPECT_LT(seconds(), kSoon_s);
  is_over = true;
  trickle.join();
  // A header without end.
  const SlowClient endless(port_);
  for (int i = 0; i < 100; ++i) endless.send("X-Filler: " + std::string(10'000, 'x') + "\r\n");
  EXPECT_LT(seconds(), kSoon_s);
}

TEST_F(ViewCli, TheTokenNeedNotBeOnTheCommandLine) {
  make_street_scene(3);
  std::ofstream(folder_ / "token.txt") << "a b&c=#\r\nsecond line\n";
  const auto expect_token = [&](const std::string& token) {
    EXPECT_EQ(client_->Get("/api/scene", {{"X-Simuli-Token", "other"}})->status, 401);
    EXPECT_EQ(client_->Get("/api/scene", {{"X-Simuli-Token", token}})->status, 200);
  };
  start({"--token-file", (folder_ / "token.txt").string()});
  expect_token("a b&c=#");
  EXPECT_NE(viewer_->output().find("/?token=a%20b%26c%3D%23\n"), std::string::npos) << viewer_->output();
  ::setenv("SIMULI_VIEW_TOKEN", "of the environment", 1);
  start();
  ::unsetenv("SIMULI_VIEW_TOKEN");
  expect_token("of the environment");
}

TEST_F(ViewCli, OtherHostsNeedAToken) {
  make_street_scene(3);
  expect_failure("view s.scene --host 0.0.0.0 --port 0", kUsage, "--token");
  start({"--token", "secret"});
  EXPECT_EQ(client_->Get("/api/scene")->status, 401);
  EXPECT_EQ(client_->Get("/api/scene", {{"X-Simuli-Token", "Secret"}})->status, 401);
  EXPECT_EQ(client_->Get("/api/scene", {{"X-Simuli-Token", "secret"}})->status, 200);
  expect_failure("view s.scene --host 0.0.0.0 --port 0 --token a --token-file b", kUsage, "--token");
  expect_failure("view s.scene --port 0 --token-file none", kInput, "none: ");
  std::ofstream(folder_ / "token.txt") << "\nsecret\n";
  expect_failure("view s.scene --port 0 --token-file token.txt", kInput, "an empty line");
  expect_failure("view s.scene --port " + std::to_string(port_), kUsage, "--port");  // taken
}

}  // namespace
