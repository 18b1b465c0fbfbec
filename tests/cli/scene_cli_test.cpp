// Commands that train and render.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "io/base/file.hpp"
#include "optim/eval/held_out_scores.hpp"
#include "optim/train/training.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

/// A small street and a scene trained on it for three iterations.
class SceneCli : public Cli {
 protected:
  void make_scene() const {
    make_street("--no-moving-car");
    const Outcome train = run("train s.log -o s.scene --iterations 3 --json --set init.voxel_m=0.3");
    ASSERT_EQ(train.exit_code, 0) << train.err;
    const nlohmann::json report = nlohmann::json::parse(train.out);
    EXPECT_EQ(report.at("iterations"), 3);
    EXPECT_EQ(report.at("rejected_gradients"), 0);
    EXPECT_EQ(report.at("images"), 5);  // of 6, one is held out
    EXPECT_EQ(train.err, "");
  }
  std::size_t files_in(const std::string& folder) const {
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(folder_ / folder))
      files += entry.is_regular_file() ? 1 : 0;
    return files;
  }
};

TEST_F(SceneCli, TrainingIsReported) {
  make_scene();
  const Outcome train =
      run("train s.log -o again.scene --iterations 3 --set init.voxel_m=0.3 --no-cache --json-progress "
          "--report train.html --tensorboard runs");
  ASSERT_EQ(train.exit_code, 0) << train.err;
  // Every line of progress is an object of its own; the last of the training holds its numbers.
  std::istringstream lines(train.err);
  nlohmann::json last;
  std::map<std::string, double> share;  // of each task that goes on
  std::set<std::string> ended;
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json object = nlohmann::json::parse(line);
    if (object.at("task") == "train") last = object;
    // One bar a stage, which never goes back, and no time that can't be known.
    const std::string task = object.at("task");
    const auto [at, is_new] = share.emplace(task, 0.0);
    const double done = object.at("done"), total = object.at("total");
    EXPECT_TRUE(!is_new || ended.count(task) == 0) << line;
    EXPECT_GE(done / total, at->second) << line;
    at->second = done / total;
    EXPECT_TRUE(done / total >= 0.05 || object.at("left_s").is_null()) << line;
    if (object.at("finished")) share.erase(task), ended.insert(task);
  }
  EXPECT_TRUE(share.empty());
  EXPECT_EQ(ended,
            (std::set<std::string>{"learn sensors",
                                   "find what moves",
                                   "initialise",
                                   "compile kernels",
                                   "train",
                                   "complete the scene",
                                   "evaluate"}));
  EXPECT_EQ(last.at("done"), 3);
  EXPECT_EQ(last.at("finished"), true);
  EXPECT_TRUE(last.at("psnr_db").is_number());
  EXPECT_GT(last.at("device_bytes"), 0);
  EXPECT_GT(fs::file_size(folder_ / "train.html"), 10'000U);
  EXPECT_EQ(files_in("runs"), 1U);
}

/// train ends with what eval and info say under the same names, and with what to type next.
TEST_F(SceneCli, TrainEndsWithTheScoresThatEvalAndInfoTell) {
  make_street("--no-moving-car");
  const Outcome train = run("train s.log -o 'a scene' --iterations 3 --set init.voxel_m=0.3");
  ASSERT_EQ(train.exit_code, 0) << train.err;
  const std::string eval = run("eval 'a scene' s.log").out, info = run("info 'a scene'").out;
  std::istringstream lines(train.out.substr(train.out.find("held-out frames: 1 picture of ")));
  std::string line;
  int scores = 0;
  for (std::getline(lines, line); std::getline(lines, line) && line.starts_with("  "); ++scores) {
    EXPECT_NE(eval.find(line + '\n'), std::string::npos) << line << '\n' << eval;
    EXPECT_NE(info.find(line + '\n'), std::string::npos) << line << '\n' << info;
  }
  EXPECT_EQ(scores, 6);
  EXPECT_EQ(line, "next    simuli view 'a scene'");
  std::getline(lines, line);
  EXPECT_EQ(line, "        simuli eval 'a scene' s.log --report 'a scene.html'");
  EXPECT_EQ(train.err.find("find what moves"), std::string::npos) << train.err;  // short: not told in a file

  // The same as JSON, and particles as they are in the scene.
  const nlohmann::json reported =
      nlohmann::json::parse(run("train s.log -o b --iterations 3 --set init.voxel_m=0.3 --json").out);
  const nlohmann::json kept = nlohmann::json::parse(run("info b --json").out);
  const nlohmann::json compared = nlohmann::json::parse(run("eval b s.log --json").out);
  EXPECT_EQ(reported.at("held_out"), kept.at("training").at("held_out"));
  for (const auto& [key, value] : reported.at("held_out").items()) EXPECT_EQ(value, compared.at(key)) << key;
  EXPECT_EQ(reported.at("camera_particles"), kept.at("camera_set").at("particles"));
  EXPECT_EQ(reported.at("lidar_particles"), kept.at("lidar_set").at("particles"));

  // Nothing was held out, as asked for, or because every tenth of six frames is none; a report shows all.
  for (const char* how : {"0", "10"}) {
    const std::string train_all =
        fmt::format("train s.log -o c{0} --iterations 1 --set init.voxel_m=0.3 --held-out {0}", how);
    const Outcome all = run(train_all);
    ASSERT_EQ(all.exit_code, 0) << all.err;
    EXPECT_NE(all.out.find("no frame was held out: no scores\n"), std::string::npos) << all.out;
    EXPECT_EQ(all.err.find("evaluate"), std::string::npos) << all.err;
  }
  EXPECT_EQ(
      run("train s.log -o d --iterations 1 --set init.voxel_m=0.3 --held-out 10 --report d.html").exit_code,
      0);
}

/// What first users typed.
TEST_F(SceneCli, SmallThingsAreTakenOrRefusedInOneLine) {
  make_street();
  const Outcome train = run("train s.log -o s.scene --iterations 1 --set init.voxel_m=0.3 --json");
  ASSERT_EQ(train.exit_code, 0) << train.err;
  // All sensors of the scene where none is named; one frame by its number.
  const Outcome all = run("render s.scene --frames 2 -o all");
  ASSERT_EQ(all.exit_code, 0) << all.err;
  EXPECT_EQ(all.out, "1 frame of front in all/front\n1 frame of top in all/top\n");
  EXPECT_TRUE(fs::exists(folder_ / "all" / "front" / "front_000002.png"));
  // Tracks of scenes, too; and who is in no frame is told of.
  const Outcome seen =
      run("render s.scene --sensor front --frames 0 --duplicate car:twin -o a "
          "--track twin:s.scene:car --move twin:5,0,0");
  EXPECT_EQ(seen.exit_code, 0) << seen.err;
  EXPECT_EQ(seen.err.find("note:"), std::string::npos) << seen.err;
  const Outcome behind =
      run("render s.scene --sensor front --frames 0 --duplicate car:twin --move twin:-60,0,0 -o b");
  EXPECT_NE(behind.err.find("simuli: note: twin is visible in none of these frames"), std::string::npos)
      << behind.err;
  EXPECT_EQ(run("help render").out, run("render --help").out);
  EXPECT_EQ(run("version").out, run("--version").out);
  std::ofstream(folder_ / "a.usdz") << "PK";
  std::ofstream(folder_ / "a.json") << "{\"a\": ";
  struct Case {
    const char* arguments;
    int exit_code;
    const char* reported;
  };
  for (const Case& c :
       {Case{"render s.scene --sensor front --lane-shift left -o x",
             kUsage,
             "--lane-shift: found left, allowed a number"},
        Case{"render s.scene --sensor front --frames 9 -o x",
             kUsage,
             "found \"9\", allowed a or a:b with 0 <= a"},
        Case{"train s.log -o x --held-out a", kUsage, "--held-out: found a, allowed a whole number"},
        Case{"--device nosuch devices", static_cast<int>(simuli::ErrorKind::kDevice), "nosuch"},
        Case{"info a.usdz", kInput, "a.usdz: file: found other data, allowed JSON of a sensor; splats"},
        Case{"info a.json", kInput, "a.json: JSON: found parse error"},
        Case{"export s.scene --at 50 -o x.ply", kUsage, "--at: found 50, allowed "}}) {
    expect_failure(c.arguments, c.exit_code, c.reported);
  }
}

TEST_F(SceneCli, ALogIsNoSceneAndIsToldSo) {
  make_scene();
  expect_failure("train s.scene -o x", kInput, "log: found a scene, allowed a log's folder: simuli import");
  expect_failure(
      "render s.log -o out", kInput, "s.log: scene: found a log, allowed a scene's folder: simuli train");
}

TEST_F(SceneCli, WhatIsComparedIsCalledByItsName) {
  make_scene();
  const auto eval = [this](const std::string& arguments) {
    const Outcome outcome = run("eval " + arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome;
  };
  const Outcome held_out = eval("s.scene s.log");
  EXPECT_EQ(held_out.out.rfind("held-out frames: 1 picture of 32 x 18 px", 0), 0U) << held_out.out;
  EXPECT_EQ(eval("s.scene s.log --held-out 0").out.rfind("all frames, some of which were trained on: 6", 0),
            0U);
  const nlohmann::json json = nlohmann::json::parse(eval("s.scene s.log --held-out 2 --json").out);
  EXPECT_EQ(json.at("frames"), "training");
  EXPECT_EQ(json.at("training").at("held_out_every"), 5);

  ASSERT_EQ(run("train s.log -o all.scene --held-out 0 --iterations 1 --set init.voxel_m=0.3").exit_code, 0);
  EXPECT_EQ(eval("all.scene s.log").out.rfind("training frames: 6 pictures", 0), 0U);

  ASSERT_EQ(run("synth street -o other.log --frames 4 --image-width 64 --image-height 36 --lidar-columns 90 "
                "--no-moving-car")
                .exit_code,
            0);
  const Outcome other = eval("s.scene other.log");
  EXPECT_NE(other.err.find("was trained on another log, street"), std::string::npos) << other.err;
  EXPECT_EQ(other.out.rfind("all frames of a log that was not trained on: 4 pictures", 0), 0U) << other.out;
  // Otherwise than it was trained: one line says so.
  EXPECT_EQ(held_out.err.find("warning"), std::string::npos) << held_out.err;
  const Outcome unlike = eval("s.scene s.log --set render.extent=unscented");
  EXPECT_NE(unlike.err.find("render.extent=unscented (trained with exact)"), std::string::npos) << unlike.err;
  const Outcome wide = eval("s.scene s.log --set render.camera_filter_px2=0.3");
  EXPECT_NE(wide.err.find("render.camera_filter_px2=0.3 (trained with 0.0833"), std::string::npos)
      << wide.err;
  // One frame, however small the step after it would be.
  const Outcome draft = run("render s.scene --quality draft --sensor front --times 0:0:1e-300 -o draft");
  EXPECT_NE(draft.err.find("render.sh_degree=0 (trained with 3)"), std::string::npos) << draft.err;
}

TEST_F(SceneCli, TrainingDecidesHowLongItGoesOn) {
  make_scene();
  // Stopped in its first stage; what stages come to is the library's (length_test.cpp).
  const Outcome train =
      run("train s.log -o auto.scene --iterations auto --max-seconds 0.001 --json-progress --json "
          "--set init.voxel_m=0.3");
  ASSERT_EQ(train.exit_code, 0) << train.err;
  const nlohmann::json report = nlohmann::json::parse(train.out);
  EXPECT_LT(report.at("iterations"), 100);
  EXPECT_TRUE(report.at("stages").is_array());
  EXPECT_NE(train.err.find("\"left_at_most_s\""), std::string::npos) << train.err;
  expect_failure(
      "train s.log -o x.scene --iterations some", kUsage, "--iterations: found some, allowed auto, or 0");
}

/// Whoever trains and compares through the library gets what the program gets, bit for bit.
TEST_F(SceneCli, TheLibraryTrainsAndComparesAsTheProgramDoes) {
  make_scene();
  const simuli::Log log = simuli::read_log(folder_ / "s.log");
  simuli::TrainingOptions options;
  options.init.voxel_m = 0.3;
  options.train.iterations = 3;
  const simuli::Device device = simuli::Device::best();
  simuli::Training training(device, log, options);
  training.run();
  (void)simuli::write_trained_scene(
      folder_ / "own.scene", device, training.result(), log, options.train.render);
  for (const char* file : {"scene.json", "camera.ply", "lidar.ply"}) {
    const auto bytes = [&](const char* scene) { return simuli::read_file(folder_ / scene / file); };
    EXPECT_EQ(bytes("own.scene"), bytes("s.scene")) << file;
  }
  const simuli::EvalReport own = simuli::Evaluation(device, training.result(), log).run();
  const nlohmann::json program = nlohmann::json::parse(run("eval s.scene s.log --json").out);
  EXPECT_EQ(program.at("psnr_db"), own.psnr_db);
  EXPECT_EQ(program.at("ssim"), own.ssim);
  EXPECT_EQ(program.at("distance_median_m"), own.lidar.distance_median_m);
  EXPECT_EQ(program.at("chamfer_m2"), own.lidar.chamfer_m2);
  EXPECT_EQ(program.at("raydrop_accuracy"), own.lidar.raydrop_accuracy);
  EXPECT_EQ(program.at("raydrop_trivial"), own.lidar.raydrop_trivial);
  EXPECT_EQ(program.at("drop_recall"), own.lidar.drop_recall);
  EXPECT_EQ(program.at("drop_precision"), own.lidar.drop_precision);
}

TEST_F(SceneCli, InfoTellsHowASceneWasMade) {
  make_scene();
  const nlohmann::json made = nlohmann::json::parse(run("info s.scene --json").out).at("training");
  EXPECT_EQ(made.at("log").at("name"), "street");
  EXPECT_EQ(made.at("iterations"), 3);
  EXPECT_EQ(made.at("quality"), "balanced");
  const auto settings = made.at("settings").get<std::vector<std::string>>();
  EXPECT_EQ(std::count(settings.begin(), settings.end(), "init.voxel_m=0.3"), 1);
  const std::string text = run("info s.scene").out;
  EXPECT_NE(text.find("held out         every 5. frame"), std::string::npos) << text;
  // A scene of a version that didn't say is read, too.
  const fs::path file = folder_ / "s.scene" / "scene.json";
  std::ifstream in(file);
  nlohmann::json scene = nlohmann::json::parse(in);
  scene.erase("training");
  std::ofstream(file) << scene.dump();
  EXPECT_TRUE(nlohmann::json::parse(run("info s.scene --json").out).at("training").is_null());
  EXPECT_EQ(run("eval s.scene s.log").out.rfind("every 5. frame (the scene has no record", 0), 0U);
}

TEST_F(SceneCli, SceneIsTrainedEvaluatedAndRendered) {
  make_scene();
  const Outcome eval = run("eval s.scene s.log --scale 0.5 --json");
  ASSERT_EQ(eval.exit_code, 0) << eval.err;
  const nlohmann::json report = nlohmann::json::parse(eval.out);
  for (const char* key : {"psnr_db",
                          "ssim",
                          "flip",
                          "distance_median_m",
                          "medl2_m2",
                          "mean_rel_l2",
                          "intensity_rmse",
                          "raydrop_accuracy",
                          "raydrop_trivial",
                          "chamfer_m2",
                          "chamfer_m",
                          "camera_mp_per_s",
                          "lidar_mr_per_s"}) {
    ASSERT_TRUE(report.at(key).is_number()) << key;
  }
  EXPECT_EQ(report.at("image_width_px"), 32);
  EXPECT_NE(run("eval s.scene s.log --report eval.html").out.find("PSNR"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder_ / "eval.html"));

  EXPECT_EQ(run("render s.scene --sensor front --trajectory s.log --frames 1:2 -o pictures").exit_code, 0);
  EXPECT_EQ(files_in("pictures"), 3U);  // and frames.json
  EXPECT_TRUE(fs::exists(folder_ / "pictures" / "front_000001.png"));
  EXPECT_EQ(run("render s.scene --sensor top --times 0:0.2:0.1 --lane-shift 0.5 -o sweeps").exit_code, 0);
  EXPECT_EQ(files_in("sweeps"), 7U);  // a cloud and a picture each
  std::ifstream cloud(folder_ / "sweeps" / "top_000002.ply");
  std::string line;
  std::getline(cloud, line);
  EXPECT_EQ(line, "ply");
  EXPECT_EQ(run("render s.scene --sensor top --times 0:0:1 --set render.extent=exact -o exact").exit_code, 0);
  const Outcome builtin = run("render s.scene --sensor generic64 --times 0.1:0.1:1 -o other --json");
  ASSERT_EQ(builtin.exit_code, 0) << builtin.err;
  EXPECT_EQ(nlohmann::json::parse(builtin.out).at("frames"), 1);
  std::ofstream(folder_ / "list.json")
      << R"({"kind": "ray_list", "name": "four", "range_min_m": 0.5, "range_max_m": 120,
             "beam_divergence_rad": 0, "divergence_variance": 0.25, "azimuth_rad": [0, 0.1, 0.2, 3],
             "elevation_rad": [-0.1, 0.1, -0.1, 0], "time_fraction": [0, 0.2, 0.4, 0.6]})";
  const Outcome list = run("render s.scene --sensor list.json --times 0.1:0.1:1 -o list --json");
  ASSERT_EQ(list.exit_code, 0) << list.err;
  EXPECT_EQ(nlohmann::json::parse(list.out).at("sensor"), "list");
  EXPECT_TRUE(fs::exists(folder_ / "list" / "list_000000.ply"));
  EXPECT_TRUE(fs::exists(folder_ / "list" / "list_000000_range.png"));

  // A LiDAR that turns 20 times a second moves for a twentieth of a second.
  const auto cloud_of = [&](const std::string& options, const std::string& to) {
    const Outcome turn =
        run("render s.scene --sensor hesai_xt32@20 --times 0.1:0.1:1 " + options + "-o " + to);
    EXPECT_EQ(turn.exit_code, 0) << turn.err;
    std::ifstream file(folder_ / to / "hesai_xt32@20_000000.ply", std::ios::binary);
    std::stringstream bytes;
    bytes << file.rdbuf();
    EXPECT_GT(bytes.str().size(), 1000U);
    return bytes.str();
  };
  const std::string twentieth = cloud_of("--duration 0.05 ", "twentieth");
  EXPECT_EQ(cloud_of("", "as_it_says"), twentieth);
  EXPECT_NE(cloud_of("--duration 0.1 ", "tenth"), twentieth);

  expect_failure("render s.scene --sensor rear -o x", kUsage, "allowed front, top, ");
  expect_failure("render s.scene --sensor front --frames 9:9 --trajectory s.log -o x", kUsage, "--frames");
  expect_failure("render s.scene --sensor front --times 0:1 -o x", kUsage, "--times");
  expect_failure("render s.scene --sensor front --times 0:nan:1 -o x", kUsage, "--times");
  expect_failure("render s.scene --sensor front --times 90:90:1 -o x", kInput, "90");  // behind the end
  expect_failure("render s.scene --sensor front -o pictures", kInput, "pictures");     // never overwritten
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(SceneCli, BadRequestsAreRefused) {
  ASSERT_EQ(
      run("synth street -o s.log --frames 2 --image-width 32 --image-height 18 --lidar-columns 36").exit_code,
      0);
  expect_failure("train nowhere.log -o x", kInput, "nowhere.log");
  expect_failure(
      "train s.log -o x --set speed=1", kUsage, "no key \"speed\", allowed seed (\"--set help\" lists all)");
  expect_failure(
      "train s.log -o x --set init.voxle_m=1", kUsage, "allowed init.voxel_m (\"--set help\" lists all)");
  expect_failure("train s.log -o x --set camera.rate.sh=-1",
                 kUsage,
                 "--set camera.rate.sh: found -1, allowed 0 or more");
  expect_failure("train s.log -o x --set init.voxel_m=wide", kUsage, "init.voxel_m: found \"wide\"");
  expect_failure("train s.log -o x --set init.voxel_m", kUsage, "KEY=VALUE");
  expect_failure("train s.log -o x --set init.voxel_m=0.2 --set init.voxel_m=0.3", kUsage, "twice");
  expect_failure("train s.log -o x --scale 0", kUsage, "image");
  expect_failure("train s.log -o x --iterations many", kUsage, "--iterations");
  const std::string projections = "allowed unscented, linearized, monte_carlo";
  expect_failure("train s.log -o x --set render.projection=exact", kUsage, projections);
  expect_failure(
      "train s.log -o x --set render.projection=linearized", kUsage, "allowed with render.extent=unscented");
  expect_failure("train s.log -o x --set render.alpha_cut=2", kUsage, "render.alpha_cut: found 2");
  // Before the log is read.
  expect_failure(
      "train nowhere.log -o x --set render.detail=0.5", kUsage, "render.detail: found 0.5, allowed 0");
  expect_failure("eval x s.log --set render.shutter_iterations=65", kUsage, "allowed 0 to 64");
  expect_failure("eval x s.log --set render.extent=box", kUsage, "allowed unscented, exact");
  expect_failure("eval x s.log --set init.voxel_m=1",
                 kUsage,
                 "no key \"init.voxel_m\", allowed those that \"--set help\" lists");
  expect_failure("render x --sensor top -o y --set render.extent", kUsage, "KEY=VALUE");
  EXPECT_FALSE(fs::exists(folder_ / "x"));
  expect_failure("eval nowhere.scene s.log", kInput, "nowhere.scene");
  expect_failure("render nowhere.scene --sensor top -o x", kInput, "nowhere.scene");
}

TEST_F(SceneCli, EveryDevicePassesItsCheck) {
  const Outcome devices = run("devices --check --json");
  ASSERT_EQ(devices.exit_code, 0) << devices.err;
  const nlohmann::json list = nlohmann::json::parse(devices.out);
  ASSERT_FALSE(list.empty());
  for (const auto& device : list) {
    EXPECT_EQ(device.at("usable"), device.value("check_passed", false)) << device;
  }
  constexpr int kDevice = 4;
  expect_failure("eval a b --device no-such-device", kInput, "a");  // the folder is looked at first
  expect_failure("demo -o d --device no-such-device", kDevice, "no-such-device");
  EXPECT_FALSE(fs::exists(folder_ / "d"));
}

TEST_F(SceneCli, DemoLeavesLogScenePicturesAndTable) {
  const Outcome demo = run("demo -o demo --iterations 1");
  ASSERT_EQ(demo.exit_code, 0) << demo.err;
  for (const char* part :
       {"street.log/log.json", "street.scene/scene.json", "camera.png", "lidar_range.png"}) {
    EXPECT_TRUE(fs::exists(folder_ / "demo" / part)) << part;
  }
  EXPECT_NE(demo.out.find("PSNR"), std::string::npos);
}

TEST_F(SceneCli, OtherFormatsOut) {
  make_scene();
  const auto expect_file = [this](const std::string& name) {
    EXPECT_TRUE(fs::exists(folder_ / name) && fs::file_size(folder_ / name) > 0) << name;
  };
  EXPECT_EQ(run("render s.scene --sensor front --times 0:0:1 --images exr -o exr").exit_code, 0);
  expect_file("exr/front_000000.exr");
  for (const std::string format : {"pcd", "npz"}) {
    EXPECT_EQ(run("render s.scene --sensor top --times 0:0:1 --clouds " + format + " -o " + format).exit_code,
              0);
    expect_file(format + "/top_000000." + format);
  }
  const Outcome spz = run("export s.scene -o s.spz --json");
  ASSERT_EQ(spz.exit_code, 0) << spz.err;
  const auto particles = nlohmann::json::parse(spz.out).at("particles").get<int>();
  EXPECT_GT(particles, 100);
  EXPECT_EQ(nlohmann::json::parse(run("export s.spz -o s.ply --json").out).at("particles"), particles);
  EXPECT_EQ(run("export s.scene --lidar -o lidar.ply").exit_code, 0);
  expect_failure("export s.scene --lidar -o lidar.spz", kInput, "lidar.spz: kind");
  expect_failure("export s.scene -o s.splat", kInput, ".ply, .spz, .glb, .usda or .usdz");
  expect_failure("render s.scene --sensor top --clouds las -o x", kUsage, "npz");

  if (std::system("command -v ffmpeg >/dev/null") == 0) {
    const Outcome video = run("render s.scene --sensor front --times 0:0.3:0.1 -o 'it'\\''s.mp4'");
    EXPECT_EQ(video.exit_code, 0) << video.err;
    expect_file("it's.mp4");
    const std::string reported = (folder_ / "told.txt").string();
    const std::string probe =
        "ffprobe -v error -select_streams v -show_entries stream=color_range,color_space,"
        "color_primaries,color_transfer -of csv=p=0 '" +
        (folder_ / "it's.mp4").string();
    const std::string quoted =
        std::string(probe).replace(probe.find("it's"), 4, "it'\\''s") + "' > '" + reported + "'";
    if (std::system("command -v ffprobe >/dev/null") == 0 && std::system(quoted.c_str()) == 0) {
      std::string line;
      std::getline(std::ifstream(reported) >> std::ws, line);
      EXPECT_EQ(line, "tv,bt709,bt709,bt709");
    }
  }
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  expect_failure("render s.scene --sensor front --times 0:0:1 -o v.mp4", kUsage, "no program ffmpeg");
  setenv("PATH", path.c_str(), 1);
}

}  // namespace
