// The viewer's answers over HTTP.
#include <Eigen/Core>  // before the macros of the HTTP library
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "io/base/file.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/splat_file.hpp"
#include "tests/cli/background_program.hpp"
#include "tests/cli/view/view_fixture.hpp"
#include "tests/io/ascii_ply.hpp"

namespace view_cli_test {

using namespace simuli::test;
using nlohmann::json;

TEST_F(ViewCli, AnswersWithPicturesAndSweeps) {
  make_street_scene(3);
  start();
  const httplib::Result page = client_->Get("/");
  ASSERT_TRUE(page);
  EXPECT_NE(page->body.find("<title>simuli view</title>"), std::string::npos);
  for (const char* part : {"/style.css",
                           "/math.js",
                           "/points.js",
                           "/live.js",
                           "/state.js",
                           "/panes.js",
                           "/actors.js",
                           "/view.js"}) {
    EXPECT_EQ(client_->Get(part)->status, 200) << part;
  }
  const json scene = json::parse(client_->Get("/api/scene")->body);
  EXPECT_EQ(scene.at("cameras"), json({"front"}));
  EXPECT_EQ(scene.at("lidars"), json({"top"}));
  EXPECT_GT(scene.at("builtin_lidars").size(), 30U);
  ASSERT_EQ(scene.at("actors").size(), 1U);

  const Reply picture = post("/api/picture", view_of("front"));
  ASSERT_EQ(picture.status, 200) << picture.body;
  EXPECT_EQ(picture.payload.substr(0, 3), "\xFF\xD8\xFF");  // a JPEG
  const Reply sweep = post("/api/sweep", view_of("top"));
  ASSERT_EQ(sweep.status, 200) << sweep.body;
  EXPECT_GT(sweep.payload.size(), 28U * 500U);
  ASSERT_EQ(sweep.payload.size() % 28U, 0U);
  std::vector<float> points(sweep.payload.size() / 4);
  std::memcpy(points.data(), sweep.payload.data(), sweep.payload.size());
  float last_ring = 0, last_time = 0, on_car = 0;
  for (std::size_t i = 0; i < points.size(); i += 7) {
    last_ring = std::max(last_ring, points[i + 4]);
    last_time = std::max(last_time, points[i + 5]);
    on_car += points[i + 6];
  }
  EXPECT_GT(last_ring, 30.0F);
  EXPECT_GT(last_time, 0.9F);
  EXPECT_LE(last_time, 1.0F);
  EXPECT_GT(on_car, 10.0F);  // of the car, the first actor
  EXPECT_EQ(sweep.info.at("actors").at(0).at("is_there"), true);
  // Over the picture those returns that it shows, and where.
  json over = view_of("front");
  over["points"] = "top";
  const Reply with = post("/api/picture", over);
  ASSERT_EQ(with.status, 200) << with.body;
  const auto seen = with.info.at("points").get<std::size_t>();
  ASSERT_GT(seen, 100U);
  EXPECT_LT(seen, points.size() / 7);
  EXPECT_EQ(with.payload.substr(seen * 36U), picture.payload);
  const std::size_t found = sweep.payload.find(with.payload.substr(0, 28));
  EXPECT_EQ(found % 28U, 0U);
  float at[2];
  std::memcpy(at, with.payload.data() + 28, sizeof(at));
  EXPECT_TRUE(at[0] >= 0.0F && at[0] <= 1.0F && at[1] >= 0.0F && at[1] <= 1.0F) << at[0] << ' ' << at[1];
  over["points"] = "front";
  EXPECT_EQ(post("/api/picture", over).status, 400);
  // Another camera and another LiDAR in the same place.
  EXPECT_EQ(post("/api/picture", view_of("pandaset_front_camera")).status, 200);
  EXPECT_EQ(post("/api/sweep", view_of("velodyne_vlp16")).status, 200);
}

TEST_F(ViewCli, ViewsDependOnWhatIsAsked) {
  make_street_scene(3);
  start();
  const std::string plain = post("/api/picture", view_of("front")).payload;
  EXPECT_EQ(post("/api/picture", view_of("front")).payload, plain);
  const auto changed = [&](const char* key, const json& value) {
    json view = view_of("front");
    view[key] = value;
    const Reply reply = post("/api/picture", view);
    EXPECT_EQ(reply.status, 200) << key << ": " << reply.body;
    return reply.payload;
  };
  EXPECT_NE(changed("left_m", 1.0), plain);
  EXPECT_NE(changed("yaw_rad", 0.2), plain);
  EXPECT_NE(changed("width", 128), plain);
  EXPECT_NE(changed("quality", "draft"), plain);
  EXPECT_NE(changed("scene_from_camera", {{"t", {0, 0, 10}}, {"q", {0.5, -0.5, 0.5, -0.5}}}), plain);
  EXPECT_NE(changed("layer", "opacity"), changed("layer", "depth"));
  EXPECT_EQ(changed("lossless", true).substr(0, 4), "\x89PNG");
  json deep = view_of("front");
  deep["layer"] = "depth";
  const json scale = post("/api/picture", deep).info;
  EXPECT_GT(scale.at("near_m"), 0.0);
  EXPECT_GE(scale.at("far_m"), 2.0 * scale.at("near_m").get<double>());
  // Where the recorded camera looked nothing is hatched, behind it all is.
  json unseen = view_of("front");
  unseen["layer"] = "unseen";
  const Reply ahead = post("/api/picture", unseen);
  EXPECT_EQ(ahead.status, 200) << ahead.body;
  EXPECT_LT(ahead.info.at("unseen_share"), 0.05);
  unseen["yaw_rad"] = 3.1;
  EXPECT_GT(post("/api/picture", unseen).info.at("unseen_share"), 0.9);
  // A pinhole camera of any shape, anywhere.
  json free = view_of("front");
  free["scene_from_camera"] = {{"t", {0, 0, 10}}, {"q", {0.5, -0.5, 0.5, -0.5}}};
  free["height"] = 200;
  EXPECT_EQ(post("/api/picture", free).status, 200);
  // The car is taken away, and moved.
  json view = view_of("top");
  const Reply all = post("/api/sweep", view);
  view["removed"] = {"car"};
  const Reply without = post("/api/sweep", view);
  ASSERT_EQ(without.status, 200) << without.body;
  EXPECT_EQ(without.info.at("actors").at(0).at("is_there"), false);
  EXPECT_NE(without.payload, all.payload);
  view["removed"] = json::array();
  view["moved"] = {{"car", {2.0, 0.0, 0.0}}};
  const Reply moved = post("/api/sweep", view);
  const json& before = all.info.at("actors").at(0).at("t");
  const json& after = moved.info.at("actors").at(0).at("t");
  const double dx = after.at(0).get<double>() - before.at(0).get<double>();
  const double dy = after.at(1).get<double>() - before.at(1).get<double>();
  EXPECT_NEAR(std::hypot(dx, dy), 2.0, 1e-6);
  // Turned where it was moved to; half as fast it is elsewhere.
  view["turned_deg"] = {{"car", 90.0}};
  const json turned = post("/api/sweep", view).info.at("actors").at(0);
  EXPECT_EQ(turned.at("t"), after);
  EXPECT_NE(turned.at("q"), moved.info.at("actors").at(0).at("q"));
  view["retimed"] = {{"car", {0.5, 0.0}}};
  EXPECT_NE(post("/api/sweep", view).info.at("actors").at(0).at("t"), after);
}

TEST_F(ViewCli, ActorsAreAddedForTheSession) {
  make_street_scene(3);
  start();
  const auto actors = [&] { return json::parse(client_->Get("/api/scene")->body).at("actors"); };
  const auto version = [&] { return json::parse(client_->Get("/api/status")->body).at("version"); };
  const json before = version();
  const auto made = [&](const std::string& path, const std::string& body) {
    const httplib::Result result = client_->Post(path, body, "application/octet-stream");
    EXPECT_EQ(result->status, 200) << result->body;
    return json::parse(result->body);
  };
  EXPECT_EQ(made("/api/duplicate", R"({"actor": "car"})").at("actor"), "car_2");
  EXPECT_EQ(made("/api/duplicate", R"({"actor": "car"})").at("actor"), "car_3");
  EXPECT_EQ(actors().size(), 3U);
  EXPECT_NE(version(), before);
  // All of a street as an actor of itself: what stands still of it.
  const std::string splats = simuli::read_file(folder_ / "s.scene" / "camera.ply");
  simuli::SceneFile scene = simuli::read_scene(folder_ / "s.scene");
  scene.scene.camera.actor.clear();
  simuli::write_splats(folder_ / "all.spz", scene.scene.camera);
  const std::string plain = post("/api/sweep", view_of("top")).payload;
  const json added = made("/api/add?file=a%20b.spz&time_s=0.2", simuli::read_file(folder_ / "all.spz"));
  EXPECT_EQ(added.at("actor"), "a b");
  EXPECT_GT(added.at("moved_m").at(0), 9.0);
  EXPECT_EQ(actors().back().at("name"), "a b");
  EXPECT_TRUE(post("/api/sweep", view_of("top")).payload != plain);
  json view = view_of("front");
  view["removed"] = {"a b", "car_2", "car_3"};
  EXPECT_EQ(post("/api/picture", view).status, 200);
  EXPECT_EQ(added.at("notes"), json::array());
  EXPECT_EQ(made("/api/add?file=b.ply&time_s=0.2", half_broken_ply()).at("notes"),
            json::array({"left out: " + simuli::broken_particles(1)}));
  const auto refused = [&](const std::string& path, const std::string& body, int status, const char* part) {
    const httplib::Result result = client_->Post(path, body, "application/octet-stream");
    EXPECT_EQ(result->status, status) << result->body;
    EXPECT_NE(result->body.find(part), std::string::npos) << result->body;
    EXPECT_EQ(result->body.find("/tmp"), std::string::npos) << result->body;
  };
  refused("/api/duplicate", R"({"actor": "bus"})", 400, "bus");
  refused("/api/add?file=a.ply&time_s=0", splats, 400, "a.ply: actor");
  refused("/api/add?file=a.ply&time_s=0", splats.substr(0, 3000), 400, "a.ply: ");
  refused("/api/add?file=a.txt&time_s=0", splats, 400, "extension");
  refused("/api/add?file=../../a.ply&time_s=x", splats, 400, "time_s");
  refused("/api/add?file=a.ply&time_s=0", std::string((60U << 20U) + 1U, ' '), 413, "62914560");
  refused("/api/picture", std::string((1U << 20U) + 1U, ' '), 413, "1048576");
  EXPECT_EQ(actors().size(), 5U);  // the car, its two, "a b" and "b"
}

TEST_F(ViewCli, RefusesPicturesOfAnySize) {
  make_street_scene(3);
  json scene = json::parse(std::ifstream(folder_ / "s.scene" / "scene.json"));
  scene["cameras"][0]["height_px"] = 60'000;
  scene["cameras"][0]["fy_px"] = 60.0;  // the least for that height
  std::ofstream(folder_ / "s.scene" / "scene.json") << scene.dump();
  start();
  json view = view_of("front");
  view["width"] = 4096;
  const Reply large = post("/api/picture", view);
  EXPECT_EQ(large.status, 400);
  EXPECT_NE(large.body.find("allowed 16777216"), std::string::npos) << large.body;
  view["width"] = 96;
  EXPECT_NE(post("/api/picture", view).body.find("and 65500"), std::string::npos);
  view["width"] = 64;
  EXPECT_EQ(post("/api/picture", view).status, 200);
}

TEST_F(ViewCli, RefusesWhatItCantShow) {
  make_street_scene(3);
  start();
  json view = view_of("nobody");
  EXPECT_EQ(post("/api/picture", view).status, 400);
  EXPECT_NE(post("/api/picture", view).body.find("found \"nobody\""), std::string::npos);
  view = view_of("front");
  view["removed"] = {"nobody"};
  EXPECT_EQ(post("/api/picture", view).status, 400);
  view = view_of("front");
  view["width"] = 100'000;
  EXPECT_NE(post("/api/picture", view).body.find("width"), std::string::npos);
  view = view_of("front");
  view["quality"] = "best";
  EXPECT_EQ(post("/api/picture", view).status, 400);
  view = view_of("front");
  view["time"] = 0.0;  // a key that is not known
  EXPECT_EQ(post("/api/picture", view).status, 400);
  EXPECT_EQ(post("/api/picture", std::string("{")).status, 400);
  const Reply deep = post("/api/picture", std::string(100'000, '[') + std::string(100'000, ']'));
  EXPECT_EQ(deep.status, 400);
  EXPECT_NE(deep.body.find("found more than 64 levels"), std::string::npos) << deep.body;
  EXPECT_EQ(client_->Get("/etc/passwd")->status, 404);
  // A name that somebody has pointed here.
  EXPECT_EQ(client_->Get("/", {{"Host", "example.org"}})->status, 403);
  EXPECT_EQ(client_->Get("/", {{"Host", "localhost:1"}})->status, 200);
  EXPECT_EQ(post("/api/picture", view_of("front")).status, 200);  // still there
}

TEST_F(ViewCli, TellsWhatIsAtAPixel) {
  make_street_scene(3);
  start();
  const auto probed = [&](const json& at) {
    json view = view_of("front");
    view["pixel"] = at;
    const httplib::Result result = client_->Post("/api/probe", view.dump(), "application/json");
    EXPECT_EQ(result->status, 200) << result->body;
    return json::parse(result->body);
  };
  const json road = probed({0.5, 0.95});
  EXPECT_GT(road.at("opacity"), 0.5);
  EXPECT_GT(road.at("distance_m"), 1.0);
  EXPECT_LT(road.at("distance_m"), 20.0);
  EXPECT_LE(road.at("depth_m"), road.at("distance_m"));
  EXPECT_EQ(road.at("actor"), nullptr);
  EXPECT_EQ(road.at("point").size(), 3U);
  EXPECT_TRUE(road.at("support").is_number());
  // In the middle of the car's box, as the picture has it.
  const json boxes = post("/api/picture", view_of("front")).info.at("boxes");
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_EQ(boxes.at(0).at("name"), "car");
  double low[2] = {1, 1}, high[2] = {0, 0};
  for (const json& line : boxes.at(0).at("lines")) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      low[i % 2] = std::min(low[i % 2], line.at(i).get<double>());
      high[i % 2] = std::max(high[i % 2], line.at(i).get<double>());
    }
  }
  EXPECT_EQ(probed({0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])}).at("actor"), "car");
  for (const json& wrong : {json({0.5, 1.5}), json({-0.1, 0.5}), json({0.5}), json("x"), json()}) {
    json view = view_of("front");
    view["pixel"] = wrong;
    EXPECT_EQ(client_->Post("/api/probe", view.dump(), "application/json")->status, 400) << wrong;
  }
  EXPECT_EQ(client_->Post("/api/probe", view_of("front").dump(), "application/json")->status, 400);
}

TEST_F(ViewCli, ALogIsShownBeforeItIsTrainedOn) {
  make_street();
  start_scene("s.log");
  const json log = json::parse(client_->Get("/api/scene")->body);
  EXPECT_EQ(log.at("kind"), "log");
  EXPECT_EQ(log.at("frames").at("front").size(), log.at("frames").at("top").size());
  json view = view_of("front");
  view["quality"] = "";
  view["points"] = "top";
  const Reply picture = post("/api/picture", view);
  ASSERT_EQ(picture.status, 200) << picture.body;
  const auto count = picture.info.at("points").get<std::size_t>();
  ASSERT_GT(count, 100U);
  EXPECT_EQ(picture.payload.substr(count * 36U, 3), "\xFF\xD8\xFF");
  // The first point's own place in the picture is where it is found again.
  std::vector<float> first(9);
  std::memcpy(first.data(), picture.payload.data(), 36);
  json at = view;
  at["pixel"] = {first[7], first[8]};
  const json found = json::parse(client_->Post("/api/probe", at.dump(), "application/json")->body);
  EXPECT_NEAR(found.at("point").at(0).get<double>(), first[0], 1e-4);
  EXPECT_GT(found.at("distance_m"), 0.5);
  json several = view_of("top");
  several["quality"] = "";
  for (const json& span : log.at("frames").at("top")) {  // where one sweep ends the next begins
    several["time_s"] = span.at(0);
    EXPECT_EQ(post("/api/sweep", several).info.at("time_s"), span.at(0));
  }
  const std::size_t one = post("/api/sweep", several).payload.size();
  several["sweeps"] = 3;
  const Reply sweeps = post("/api/sweep", several);
  EXPECT_EQ(sweeps.info.at("sweeps"), 3);
  EXPECT_GT(sweeps.payload.size(), 2 * one);
  EXPECT_EQ(sweeps.info.at("actors").size(), 1U);
  const auto refused = [&](const char* path, const char* key, const json& value, const char* part) {
    json other = view;
    other[key] = value;
    const httplib::Result result = client_->Post(path, other.dump(), "application/json");
    EXPECT_EQ(result->status, 400) << key;
    EXPECT_NE(result->body.find(part), std::string::npos) << result->body;
  };
  refused("/api/picture", "left_m", 1.0, "of a log");
  refused("/api/picture", "layer", "depth", "of a log");
  refused("/api/picture", "removed", {"car"}, "of a log");
  refused("/api/picture", "sensor", "nobody", "nobody");
  refused("/api/picture", "points", "nobody", "nobody");
  refused("/api/sweep", "sweeps", 0, "sweeps");
  refused("/api/command", "width", 96, "simuli train");
  const Outcome edited = run("view " + (folder_ / "s.log").string() + " --remove car");
  EXPECT_EQ(edited.exit_code, 2);
  EXPECT_NE(edited.err.find("a log"), std::string::npos) << edited.err;
}

TEST_F(ViewCli, TrainingIsShownWhileItRuns) {
  make_street("--no-moving-car");
  const BackgroundProgram train({SIMULI_PROGRAM,
                                 "train",
                                 (folder_ / "s.log").string(),
                                 "-o",
                                 (folder_ / "s.scene").string(),
                                 "--iterations",
                                 "100000",
                                 "--set",
                                 "init.voxel_m=0.3",
                                 "--view",
                                 "0"},
                                folder_ / "train.txt");
  const int port = train.disoccluded_number("http://127.0.0.1:");
  ASSERT_GT(port, 0) << train.output();
  httplib::Client client("127.0.0.1", port);
  client.set_read_timeout(60);
  const auto status = [&] { return json::parse(client.Get("/api/status")->body); };
  for (int tries = 0; tries < 300 && status().at("iteration") < 3; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  const json now = status();
  EXPECT_EQ(now.at("training"), true);
  EXPECT_GE(now.at("iteration"), 3);
  EXPECT_EQ(now.at("iterations"), 100'000);
  EXPECT_TRUE(now.at("psnr_db").is_number());
  // A new scene comes while somebody looks on.
  for (int tries = 0; tries < 300 && status().at("version") == now.at("version"); ++tries) {
    ASSERT_EQ(client.Post("/api/picture", view_of("front").dump(), "application/json")->status, 200);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_GT(status().at("version"), now.at("version"));
}

}  // namespace view_cli_test
