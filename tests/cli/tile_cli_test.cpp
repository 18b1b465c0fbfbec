// simuli tile: numbers and a picture of any LiDAR's tiles.
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

class TileCli : public Cli {};

TEST_F(TileCli, NumbersAndPictureOfABuiltInSensor) {
  const Outcome text = run("tile velodyne_vlp16 --elevation-tiles 4 --rays 128 -o tiles.png");
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("rows per tile          4\n"), std::string::npos) << text.out;
  EXPECT_GT(fs::file_size(folder_ / "tiles.png"), 10'000U);
  const Outcome json = run("tile velodyne_vlp16 --elevation-tiles 4 --rays 128 --json");
  ASSERT_EQ(json.exit_code, 0) << json.err;
  const nlohmann::json tiles = nlohmann::json::parse(json.out);
  EXPECT_EQ(tiles.at("tile_rows"), 4);
  EXPECT_EQ(tiles.at("slots_per_tile"), 128);
  EXPECT_LE(tiles.at("rays_of_fullest_tile"), 128);
  EXPECT_GT(tiles.at("rays_of_emptiest_interior_tile"), 96);
}

TEST_F(TileCli, ASensorFileOfOnesOwn) {
  std::ofstream(folder_ / "mine.json") << run("info velodyne_vlp16 --json").out;
  const Outcome rows = run("tile mine.json --json");
  ASSERT_EQ(rows.exit_code, 0) << rows.err;
  EXPECT_EQ(nlohmann::json::parse(rows.out).at("sensor"), "velodyne_vlp16");
  std::ofstream(folder_ / "list.json")
      << R"({"kind": "ray_list", "name": "four", "range_min_m": 0.5, "range_max_m": 120,
             "beam_divergence_rad": 0, "divergence_variance": 0.25, "azimuth_rad": [0, 0.1, 0.2, 3],
             "elevation_rad": [0.1, 0.1, -0.1, 0], "time_fraction": [0, 0.2, 0.4, 0.6]})";
  const Outcome list = run("tile list.json -o list.png --json");
  ASSERT_EQ(list.exit_code, 0) << list.err;
  EXPECT_EQ(nlohmann::json::parse(list.out).at("rays"), 4);
  EXPECT_TRUE(fs::exists(folder_ / "list.png"));
}

TEST_F(TileCli, WrongInputIsOneLine) {
  expect_failure("tile", kUsage, "SENSOR");
  expect_failure("tile velodyne_vlp61", kUsage, "velodyne_vlp16");
  expect_failure("tile velodyne_vlp16 --rays 8", kUsage, "rays");
  expect_failure("tile velodyne_vlp16 --tune --rays 64", kUsage, "--tune");
  std::ofstream(folder_ / "bad.json") << "{}";
  expect_failure("tile bad.json", kInput, "bad.json");
  expect_failure("tile velodyne_vlp16 -o nowhere/tiles.png", kInput, "nowhere");
}

}  // namespace
