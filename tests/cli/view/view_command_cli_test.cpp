// The viewer's "this view as a command", run.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "io/base/file.hpp"
#include "io/picture/image.hpp"
#include "tests/cli/view/view_fixture.hpp"

namespace {

using namespace simuli::test;

TEST_F(ViewCli, AViewAsACommandMakesThatPicture) {
  make_street_scene(3);
  fs::rename(folder_ / "s.scene", folder_ / "it's a.scene");
  start_scene("it's a.scene", {"--duplicate", "car:old", "--move", "old:0,1,0"});
  json view = view_of("front");
  view["width"] = 96;
  view["lossless"] = true;
  view["left_m"] = 0.5;
  ASSERT_EQ(client_->Post("/api/duplicate", R"({"actor": "car"})", "application/json")->status, 200);
  view["removed"] = {"car"};
  view["moved"] = {{"car_2", {-1.0, 0.5, 0.0}}};
  view["turned_deg"] = {{"car_2", 30.0}};
  view["retimed"] = {{"car_2", {0.75, 0.1}}};
  const auto reported = [&] {
    const httplib::Result result = client_->Post("/api/command", view.dump(), "application/json");
    EXPECT_EQ(result->status, 200) << result->body;
    return json::parse(result->body).at("command").get<std::string>();
  };
  const auto run_told = [&](const std::string& command) {
    const std::string program = "simuli ";
    EXPECT_EQ(command.substr(0, program.size()), program);
    fs::remove_all(folder_ / "view");
    const Outcome outcome = run(command.substr(program.size()));
    EXPECT_EQ(outcome.exit_code, 0) << command << '\n' << outcome.err;
  };
  run_told(reported());
  EXPECT_EQ(simuli::read_file(folder_ / "view" / "front_000000.png"), post("/api/picture", view).payload)
      << reported();
  view["layer"] = "unseen";
  run_told(reported());
  EXPECT_EQ(simuli::read_file(folder_ / "view" / "front_000000.png"), post("/api/picture", view).payload)
      << reported();
  // From elsewhere, and another layer beside the picture.
  view["layer"] = "colour";
  view["up_m"] = 0.5;
  view["forward_m"] = -1.0;
  view["yaw_rad"] = 0.2;
  view["pitch_rad"] = -0.05;
  view["lossless"] = true;
  const auto expect_shown = [&](const char* name) {
    const simuli::Image run = simuli::read_image(folder_ / "view" / name);
    simuli::write_file_atomically(folder_ / "shown.png", post("/api/picture", view).payload);
    const simuli::Image shown = simuli::read_image(folder_ / "shown.png");
    ASSERT_EQ(run.data.size(), shown.data.size());
    double most = 0.0;
    for (std::size_t i = 0; i < run.data.size(); ++i)
      most = std::max(most, std::abs(run.data[i] - shown.data[i]) * 1.0);
    EXPECT_LE(most, 2.5 / 255.0) << "angles of the mounting are rounded";
  };
  run_told(reported());
  expect_shown("front_000000.png");
  view["layer"] = "depth";
  run_told(reported());
  EXPECT_TRUE(fs::exists(folder_ / "view" / "front_000000_distance.exr")) << reported();
  // Of another LiDAR.
  view["sensor"] = "velodyne_vlp16";
  run_told(reported());
  EXPECT_TRUE(fs::exists(folder_ / "view" / "velodyne_vlp16_000000.ply"));
  const auto refused = [&](const char* key, const json& value, const char* part) {
    json other = view_of("front");
    other[key] = value;
    const httplib::Result result = client_->Post("/api/command", other.dump(), "application/json");
    EXPECT_EQ(result->status, 400) << key;
    EXPECT_NE(result->body.find(part), std::string::npos) << result->body;
  };
  refused("moved", {{"old", {1, 0, 0}}}, "an edit of old");
  refused("sensor", "nobody", "nobody");
  // Of the 3D view's free camera: its file first.
  view = view_of("front");
  view["lossless"] = true;
  view["scene_from_camera"] = {{"t", {0, 0, 10}}, {"q", {0.5, -0.5, 0.5, -0.5}}};
  view["height"] = 100;
  const std::string both = reported(), between = " && ";
  const std::size_t second = both.find(between);
  ASSERT_NE(second, std::string::npos) << both;
  ASSERT_EQ(run_line("{ " + both.substr(0, second) + "; }").exit_code, 0) << both;
  run_told(both.substr(second + between.size()));
  expect_shown("view_free_000000.png");
}

}  // namespace
