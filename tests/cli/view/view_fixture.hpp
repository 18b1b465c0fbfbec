#pragma once
// A small scene, and the viewer that shows it.
#include <Eigen/Core>  // before the macros of the HTTP library
#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <httplib.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/cli/background_program.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace simuli::test {

using nlohmann::json;

class ViewCli : public Cli {
 protected:
  /// Starts the viewer on any free port.
  void start(const std::vector<std::string>& more = {}) { start_scene("s.scene", more); }
  void start_scene(const std::string& scene, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{SIMULI_PROGRAM, "view", (folder_ / scene).string(), "--port", "0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    viewer_ = std::make_unique<BackgroundProgram>(arguments, folder_ / "view.txt");
    port_ = viewer_->disoccluded_number("http://127.0.0.1:");
    client_ = std::make_unique<httplib::Client>("127.0.0.1", port_);  // finds nobody if it has not started
    client_->set_read_timeout(60);
    ASSERT_GT(port_, 0) << viewer_->output();
  }
  static json view_of(const std::string& sensor) {
    return {{"sensor", sensor},
            {"quality", "balanced"},
            {"time_s", 0.2},
            {"width", 96},
            {"forward_m", 0},
            {"left_m", 0},
            {"up_m", 0},
            {"yaw_rad", 0},
            {"pitch_rad", 0},
            {"layer", "colour"},
            {"lossless", false},
            {"removed", json::array()},
            {"moved", json::object()},
            {"turned_deg", json::object()},
            {"retimed", json::object()}};
  }
  struct Reply {
    int status = 0;
    std::string body;
    json info;
    std::string payload;
  };
  Reply post(const std::string& path, const std::string& body, const httplib::Headers& headers = {}) const {
    const httplib::Result result = client_->Post(path, headers, body, "application/json");
    if (!result) return {};
    Reply reply{result->status, result->body, {}, {}};
    if (reply.status != 200) return reply;
    std::uint32_t length = 0;
    std::memcpy(&length, reply.body.data(), sizeof(length));
    reply.info = json::parse(reply.body.substr(4, length));
    reply.payload = reply.body.substr(4 + (length + 3) / 4 * 4);
    return reply;
  }
  Reply post(const std::string& path, const json& view) const { return post(path, view.dump()); }

  std::unique_ptr<BackgroundProgram> viewer_;
  std::unique_ptr<httplib::Client> client_;
  int port_ = 0;
};

}  // namespace simuli::test
