// How well a render is known, and programs and edits that live by it.
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>

#include "io/base/file.hpp"
#include "io/picture/image.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace simuli {
namespace {

using namespace simuli::test;

class SupportCli : public Cli {
 protected:
  /// The scene as one from before there was support.
  void forget_support() const {
    nlohmann::json scene = nlohmann::json::parse(read_file(folder_ / "s.scene/scene.json"));
    ASSERT_EQ(scene.erase("support"), 1U);
    write_file_atomically(folder_ / "s.scene/scene.json", scene.dump());
    fs::remove(folder_ / "s.scene/support.exr");
  }
};

TEST_F(SupportCli, FallsBesideThePath) {
  make_street_scene(20);
  double means[2] = {};
  for (const int shift_m : {0, 3}) {
    const std::string to = fmt::format("shift_{}", shift_m);
    const Outcome done = run(
        fmt::format("render s.scene --sensor front --frames 1:1 --lane-shift {} --outputs rgb,support -o {}",
                    shift_m,
                    to));
    ASSERT_EQ(done.exit_code, 0) << done.err;
    const Image image = read_image(folder_ / to / "front_000001_support.exr");
    ASSERT_EQ(image.width, 64);
    EXPECT_GE(*std::min_element(image.data.begin(), image.data.end()), 0.0F);
    EXPECT_LE(*std::max_element(image.data.begin(), image.data.end()), 1.0F);
    means[shift_m > 0] =
        std::accumulate(image.data.begin(), image.data.end(), 0.0) / static_cast<double>(image.data.size());
  }
  EXPECT_GT(means[0], 0.3);
  EXPECT_LT(means[1], means[0] - 0.05);

  const Outcome bytes =
      run("render s.scene --sensor front --frames 1:1 --outputs support,opacity --values png -o bytes");
  ASSERT_EQ(bytes.exit_code, 0) << bytes.err;
  const Image exact = read_image(folder_ / "shift_0/front_000001_support.exr");
  const Image grey = read_image(folder_ / "bytes/front_000001_support.png");
  ASSERT_EQ(grey.data.size(), exact.data.size());
  for (std::size_t i = 0; i < exact.data.size(); ++i) {
    EXPECT_NEAR(grey.data[i], exact.data[i], 0.5 / 255 + 1e-6) << i;
  }
  EXPECT_TRUE(fs::exists(folder_ / "bytes/front_000001_opacity.png"));
  expect_failure("render s.scene --sensor front --frames 1:1 --outputs depth --values png -o no",
                 kUsage,
                 "found the output depth, allowed rgb, opacity, actors, support");

  const Outcome sweep = run("render s.scene --sensor top --times 0:0:1 --outputs support -o sweep");
  ASSERT_EQ(sweep.exit_code, 0) << sweep.err;
  EXPECT_NE(read_file(folder_ / "sweep/top_000000.ply").find("property float support\n"), std::string::npos);

  const Outcome eval = run("eval s.scene s.log --support --json");
  ASSERT_EQ(eval.exit_code, 0) << eval.err;
  const nlohmann::json support = nlohmann::json::parse(eval.out).at("support");
  for (const char* of : {"pixels", "rays"}) {
    EXPECT_GT(support.at(of).at("count"), 50) << of;
    EXPECT_GT(support.at(of).at("rank_correlation"), 0.2) << of;
    double shares = 0.0;
    for (const auto& bin : support.at(of).at("curve")) shares += bin.at("share").get<double>();
    EXPECT_NEAR(shares, 1.0, 1e-9) << of;
  }

  // The same scene without what it is told from.
  forget_support();
  EXPECT_EQ(run("render s.scene --sensor front --frames 1:1 -o plain").exit_code, 0);
  expect_failure(
      "render s.scene --sensor front --frames 1:1 --outputs support -o x", kUsage, "train it anew");
  expect_failure("eval s.scene s.log --support", kUsage, "train it anew");
  expect_failure(
      "render s.scene --sensor front --frames 1:1 --mirror car -o x", kUsage, "train the scene again");
}

TEST_F(SupportCli, MirrorsWhatOneSideAloneWasSeenOf) {
  make_street_scene(20);
  const Outcome done = run("render s.scene --sensor front --frames 1:1 --mirror car -o m");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const nlohmann::json frames = nlohmann::json::parse(read_file(folder_ / "m/frames.json"));
  EXPECT_EQ(frames.at("edits"), nlohmann::json({"--mirror car"}));
  expect_failure(
      "render s.scene --sensor front --frames 1:1 --mirror bus -o x", kUsage, "found \"bus\", allowed car");
}

TEST_F(SupportCli, TrainsOnWhatAProgramMends) {
  make_street();
  write_file_atomically(folder_ / "mend.sh", R"(for f in "$1"/*_support.png; do
  b=$(basename "$f" _support.png); cp "$1/$b.png" "$2/"; done
cp "$1/views.json" told_$(ls told_* 2>/dev/null | wc -l).json
)");
  const std::string train =
      "train s.log --iterations 8 --set init.voxel_m=0.3 fixer.views=2 fixer.shift_m=1.5";
  const Outcome done = run(train + " -o fixed.scene --fixer 'sh mend.sh'");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const nlohmann::json reported = nlohmann::json::parse(read_file(folder_ / "told_0.json"));
  EXPECT_EQ(reported.at("iteration"), 4);
  EXPECT_EQ(reported.at("views").size(), 4U);  // two pictures, to both sides
  EXPECT_TRUE(fs::exists(folder_ / "told_1.json"));
  EXPECT_FALSE(fs::exists(folder_ / "told_2.json"));
  ASSERT_EQ(run(train + " -o plain.scene").exit_code, 0);
  EXPECT_NE(read_file(folder_ / "fixed.scene/camera.ply"), read_file(folder_ / "plain.scene/camera.ply"));
  EXPECT_EQ(read_file(folder_ / "fixed.scene/lidar.ply"), read_file(folder_ / "plain.scene/lidar.ply"));

  const Outcome failed = run(train + " -o x.scene --fixer 'exit 9; true'");
  EXPECT_EQ(failed.exit_code, kInput);
  EXPECT_NE(failed.err.find("exit code 9"), std::string::npos) << failed.err;
  EXPECT_FALSE(fs::exists(folder_ / "x.scene"));
}

}  // namespace
}  // namespace simuli
