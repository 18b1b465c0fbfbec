// Sensors from files, as commands take them.
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/base/file.hpp"
#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

TEST_F(Cli, CamerasOfFilesAreRendered) {
  ASSERT_EQ(
      run("synth street -o s.log --frames 6 --image-width 64 --image-height 36 --lidar-columns 90").exit_code,
      0);
  ASSERT_EQ(run("train s.log -o s.scene --iterations 1 --set init.voxel_m=0.3").exit_code, 0);
  // The log's own camera, from a file: the same picture, at another size and with a read-out of its own.
  const auto picture = [&](const std::string& sensor, const std::string& options, const std::string& to) {
    const Outcome seen =
        run("render s.scene --sensor " + sensor + " --times 0.1:0.1:1 " + options + " -o " + to);
    EXPECT_EQ(seen.exit_code, 0) << seen.err;
    return simuli::read_file(folder_ / to / (sensor.substr(0, sensor.find('.')) + "_000000.png"));
  };
  nlohmann::json mine = nlohmann::json::parse(run("info s.scene front --json").out);
  std::ofstream(folder_ / "mine.json") << mine.dump();
  EXPECT_EQ(picture("mine.json", "", "mine"), picture("front", "", "front"));
  mine["shutter"] = "top_to_bottom";
  mine["readout_s"] = 0.1;
  std::ofstream(folder_ / "rolling.json") << mine.dump();
  const std::string rolling = picture("rolling.json", "", "rolling");
  EXPECT_NE(rolling, picture("front", "", "front_again"));
  EXPECT_EQ(rolling, picture("rolling.json", "--duration 0.1", "rolling_again"));
}

}  // namespace
