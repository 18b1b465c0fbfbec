// Files of splats where scenes can be given: rendered, imported, added as actors.
#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/base/file.hpp"
#include "io/picture/image.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/splat_file.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;
using simuli::GaussianSet;

class SplatCli : public Cli {
 protected:
  /// A block, 2 wide, 1 high and 4 deep, of one colour.
  void make_block(const std::string& file, const Eigen::RowVector3f& rgb) const {
    constexpr int kSide = 8;
    GaussianSet set(simuli::SetKind::kCamera, 1, kSide * kSide * kSide);
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      const auto at = [](Eigen::Index k) { return static_cast<float>(k) / (kSide - 1) - 0.5F; };
      set.mean().row(i) << 2.0F * at(i % kSide), at(i / kSide % kSide), 4.0F * at(i / kSide / kSide);
      set.log_scale().row(i) << std::log(0.15F), std::log(0.08F), std::log(0.3F);
      set.rotation()(i, 0) = 1.0F;
      set.opacity_logit()(i) = 4.0F;
      set.sh(0).row(i) = (rgb.array() - 0.5F) / simuli::kSh0;
    }
    simuli::write_splats(folder_ / file, set);
  }
  /// Of the middle of a picture.
  Eigen::Vector3f middle_of(const std::string& file) const {
    const simuli::Image image = simuli::read_image(folder_ / file);
    Eigen::Vector3f out;
    for (int c = 0; c < 3; ++c) out[c] = image.at(image.width / 2, image.height / 2, c);
    return out;
  }
};

TEST_F(SplatCli, OtherFilesOfSplatsAreToldApart) {
  make_block("red.ply", {0.9F, 0.1F, 0.2F});
  fs::copy(folder_ / "red.ply", folder_ / "red.splat");
  for (const char* command : {"info red.splat", "import splat red.splat -o r.scene"})
    expect_failure(command, kInput, "found .splat, allowed .ply");
  fs::copy(folder_ / "red.ply", folder_ / "red.mcap");
  expect_failure("info red.mcap", kInput, "found a recording, allowed a log made by simuli import mcap");
  expect_failure("view red.splat --port 0",
                 kInput,
                 "found a file, allowed a scene's folder, or splats: .ply, .spz, .glb");
}

TEST_F(SplatCli, WhatTheHeaderSaysOfOpacitiesIsTold) {
  for (const char flags : {'\0', '\1'}) {
    std::string spz("NGSP\2\0\0\0\1\0\0\0\0\14\0\0", 16);  // version 2, one particle of SH degree 0
    spz[14] = flags;
    simuli::write_file_atomically(folder_ / "a.spz", spz + std::string(19, '\x80'));
    fs::remove_all(folder_ / "out");
    for (const std::string command : {"info a.spz",
                                      "import splat a.spz --survey",
                                      "render a.spz --sensor orbit --scale 0.02 --times 0:5:5 -o out"}) {
      const Outcome done = run(command);
      EXPECT_EQ(done.exit_code, 0) << done.err;
      EXPECT_EQ((done.out + done.err).find("render.camera_compensation=true") != std::string::npos,
                flags == '\1')
          << command;
    }
  }
}

TEST_F(SplatCli, EndingsInCapitalsAreTheSame) {
  make_block("red.spz", {0.9F, 0.1F, 0.2F});
  fs::copy(folder_ / "red.spz", folder_ / "RED.SPZ");
  for (const char* command : {"info ", "import splat --survey "}) {
    const Outcome done = run(std::string(command) + "RED.SPZ");
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_NE(done.out.find("512 particles"), std::string::npos) << done.out;
  }
  fs::copy(folder_ / "red.spz", folder_ / "RED.KSPLAT");
  expect_failure("import splat RED.KSPLAT --survey", kInput, "found .ksplat, allowed .ply");
  expect_failure("render red.spz --sensor orbit --images exr -o A.MCAP", kUsage, "for an .mcap file");
  expect_failure("render red.spz --sensor orbit --as-log -o A.MP4", kUsage, "--as-log");
  expect_failure("render red.spz --sensor orbit -o A.PNG", kUsage, "--output: found \"A.PNG\"");
}

TEST_F(SplatCli, ScenesAreExported) {
  make_street_scene(3);
  const auto particles = [this](const std::string& command) {
    const Outcome done = run("export " + command + " --json");
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return nlohmann::json::parse(done.out).at("particles").get<int>();
  };
  const int still = particles("s.scene -o still.glb"), all = particles("s.scene --at 0.1 -o all.glb");
  EXPECT_LT(still, all);
  EXPECT_EQ(particles("s.scene --at 0.1 --remove car -o none.glb"), still);
  expect_failure("export s.scene --at 1000 -o none.glb", kUsage, "--at: found 1000, allowed ");
  for (const char* file : {"a.ply", "a.spz", "a.usda", "a.usdz"}) {
    EXPECT_EQ(particles("s.scene --at 0.1 -o " + std::string(file)), all) << file;
  }
  EXPECT_EQ(particles("s.scene --compress -o c.glb"), still);
  EXPECT_LT(fs::file_size(folder_ / "c.glb"), fs::file_size(folder_ / "still.glb") / 4);
  EXPECT_NE(run("export s.scene -o still.ply").err.find("left out: "), std::string::npos);
  // What is left is as it was: the scene's means, turned and turned back.
  const GaussianSet ply = simuli::read_splats(folder_ / "a.ply");
  EXPECT_EQ(particles("all.glb -o back.ply"), all);
  const GaussianSet back = simuli::read_splats(folder_ / "back.ply");  // right, down, ahead
  EXPECT_LT((back.mean().col(2) - ply.mean().col(0)).cwiseAbs().maxCoeff(), 1e-4F);
  EXPECT_LT((back.mean().col(1) + ply.mean().col(2)).cwiseAbs().maxCoeff(), 1e-4F);
  expect_failure("export a.ply --at 1 -o b.ply", kUsage, "allowed a scene for --at");
  expect_failure("export s.scene --compress -o c.ply", kInput, "compression");
  expect_failure("export s.scene --lidar -o l.usdz", kInput, "kind");
  EXPECT_FALSE(fs::exists(folder_ / "l.usdz"));
}

TEST_F(SplatCli, AFileOfSplatsIsAScene) {
  for (const char* file : {"red.ply", "red.spz", "red.glb"}) {
    make_block(file, {0.9F, 0.1F, 0.2F});
    const std::string name = std::string(file) + ".out";
    const Outcome render =
        run(fmt::format("render {} --sensor orbit --scale 0.1 --times 0:5:5 -o {}", file, name));
    ASSERT_EQ(render.exit_code, 0) << render.err;
    for (const char* picture : {"/orbit_000000.png", "/orbit_000001.png"}) {
      EXPECT_LT((middle_of(name + picture) - Eigen::Vector3f(0.9F, 0.1F, 0.2F)).norm(), 0.05F) << file;
    }
  }
  // LiDARs see the same block: 4 m deep, 2 m wide, its near face before its middle.
  const Outcome sweep =
      run("render red.spz --sensor velodyne_vlp16 --times 0:0:1 --clouds npz -o sweep --json");
  ASSERT_EQ(sweep.exit_code, 0) << sweep.err;
  EXPECT_GT(fs::file_size(folder_ / "sweep" / "velodyne_vlp16_000000.npz"), 10'000U);
  const simuli::SceneFile scene = simuli::read_scene(folder_ / "red.ply");
  EXPECT_EQ(scene.scene.lidar.size(), scene.scene.camera.size());
  EXPECT_EQ(scene.recorded_frames.at("orbit").size(), 100U);
  EXPECT_EQ(scene.recorded_frames.at("hesai_xt32").size(), 100U);
  make_block("none.ply", {0, 0, 0});
  fs::resize_file(folder_ / "none.ply", 100);
  expect_failure("render none.ply --sensor orbit -o x", kInput, "none.ply");
  expect_failure("render red.txt --sensor orbit -o x", kInput, "red.txt");
}

TEST_F(SplatCli, ImportPlacesASplat) {
  make_block("red.ply", {0.9F, 0.1F, 0.2F});
  const auto size = [&](const std::string& options) {
    const Outcome done = run("import splat red.ply --json -o x.scene " + options);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    const auto out = nlohmann::json::parse(done.out);
    fs::remove_all(folder_ / "x.scene");
    return std::array{out.at("size_m").get<std::array<double, 3>>(),
                      out.at("from_m").get<std::array<double, 3>>()};
  };
  const auto expect_near = [](const std::array<double, 3>& found, const std::array<double, 3>& wanted) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found[k], wanted[k], 1e-4);
  };
  // Forward is its z, up its -y.
  expect_near(size("")[0], {4, 2, 1});
  expect_near(size("--axes z-up")[0], {2, 1, 4});
  expect_near(size("--axes y-up --metres-per-unit 3")[0], {12, 6, 3});
  const auto placed = size("--pose 1000000,20,-3,0,0,90");
  expect_near(placed[0], {2, 4, 1});
  expect_near(placed[1], {999999, 18, -3.5});
  ASSERT_EQ(run("import splat red.ply -o y.scene").exit_code, 0);
  EXPECT_EQ(simuli::read_scene(folder_ / "y.scene").scene.camera.params,
            simuli::read_scene(folder_ / "red.ply").scene.camera.params);
  // As wide as the programs that make splats take a pixel.
  for (const char* scene : {"red.ply", "y.scene"})
    EXPECT_EQ(simuli::read_scene(folder_ / scene).scene.camera_filter_px2, 0.3) << scene;
  EXPECT_NE(run("info y.scene").out.find("camera filter 0.3000 px2"), std::string::npos);
  const std::string survey = run("import splat red.ply --survey").out;
  EXPECT_EQ(run("import splat red.ply -o w.scene").out,
            survey.substr(0, survey.size() - 1) + ", in w.scene\n");
  expect_failure(
      "import splat red.ply", kUsage, "--output: found \"\", allowed a folder to write, or --survey");
  expect_failure("import splat red.ply -o y.scene", kInput, "y.scene");
  expect_failure("import splat red.ply -o z.scene --pose 1,2,3", kUsage, "--pose: found \"1,2,3\"");
  expect_failure("import splat red.ply -o z.scene --metres-per-unit 0", kUsage, "--metres-per-unit");
}

TEST_F(SplatCli, ASplatIsAddedAsAnActor) {
  make_block("red.ply", {0.9F, 0.1F, 0.2F});
  make_block("blue.spz", {0.1F, 0.2F, 0.9F});
  const auto picture = [&](const std::string& name, const std::string& edits) {
    const Outcome done = run("render red.ply --sensor orbit --scale 0.1 --times 0:0:1 -o " + name + edits);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return middle_of(name + "/orbit_000000.png");
  };
  const Eigen::Vector3f red(0.9F, 0.1F, 0.2F), blue(0.1F, 0.2F, 0.9F);
  // It stands where the path begins; 4 m ahead of that is before the block, and the rig looks down at it.
  const std::string add = " --add blue.spz:post --move post:4,0,-1.6";
  EXPECT_LT((picture("a", add) - blue).norm(), 0.1F);
  EXPECT_LT((picture("b", add + " --resize post:0.02") - red).norm(), 0.1F);
  EXPECT_LT((picture("c", add + " --remove post") - red).norm(), 0.1F);
  EXPECT_LT((picture("d", " --add blue.spz:post --move post:0,0,-50") - red).norm(), 0.1F);
  // Turned about itself, across the view: its near face is farther away.
  EXPECT_LT((picture("e", " --add blue.spz:post --move post:4,-1.7,-1.6 --turn post:90") - blue).norm(),
            0.1F);
  EXPECT_LT((picture("f", " --add blue.spz:post --move post:4,-1.7,-1.6") - red).norm(), 0.1F);
  const std::string render = "render red.ply --sensor orbit -o x ";
  expect_failure(render + "--add blue.spz", kUsage, "SPLAT:NAME");
  expect_failure(render + "--add blue.spz:a:b", kUsage, "SPLAT:NAME");
  expect_failure(render + "--add blue.spz:../a", kInput, "name");
  expect_failure(render + "--add no.spz:a", kInput, "no.spz");
  expect_failure(render + "--turn post:west", kUsage, "ACTOR:DEGREES");
  expect_failure(render + "--resize post:0", kUsage, "post");
}

}  // namespace
