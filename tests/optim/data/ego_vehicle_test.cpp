#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

#include "optim/data/sensor_learning.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::Scratch;

constexpr int kColumns = 36;
constexpr double kStep_rad = 2.0 * std::numbers::pi / kColumns;

Lidar three_rows() {
  Lidar lidar;
  lidar.name = "roof";
  lidar.rows = {{0.05}, {-0.2}, {-0.4}};
  lidar.columns = kColumns;
  lidar.azimuth_first = 0.5 * kStep_rad;
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.range_min = 0.5;
  lidar.range_max = 100.0;
  return lidar;
}

/// Whether (row, column) of sweep `index` returns.
using Returns = std::function<bool(int index, int row, int column)>;

/// Range of the ray in m.
using Ranges = std::function<double(int index, int row, int column)>;

Log log_of(
    const Scratch& folder,
    int sweeps,
    double speed_mps,
    const Returns& returns,
    const Ranges& range_m = [](int, int, int) { return 9.0; }) {
  Log log;
  log.folder = folder.path();
  log.lidars.push_back({three_rows(), Pose{}});
  std::vector<TimedPose> poses;
  for (int i = 0; i <= sweeps; ++i) {
    TimedPose pose{0.1 * i, {}};
    pose.pose.translation.x() = speed_mps * pose.time_s;
    poses.push_back(pose);
  }
  log.world_from_rig = Trajectory(poses);
  for (int i = 0; i < sweeps; ++i) {
    Sweep sweep{nominal_rays(three_rows()), {}, {}};
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        sweep.range.push_back(returns(i, row, column) ? static_cast<float>(range_m(i, row, column)) : 0.0F);
        sweep.intensity.push_back(returns(i, row, column) ? 0.5F : 0.0F);
      }
    }
    const std::string name = fmt::format("{:02}.exr", i);
    write_sweep(folder / name, sweep);
    log.sweeps.push_back({"roof", name, 0.1 * i, 0.1 * (i + 1)});
  }
  return log;
}

/// The bonnet hides columns 5 to 12 of the lowest row; the sky has no returns; two cells have none by chance;
/// held-out sweeps, every fifth, have all returns.
bool bonnet(int index, int row, int column) {
  if (index % 5 == 4) return true;
  if (row == 0) return false;
  if (row == 1) return column != 20 && column != 21;
  return column < 5 || column > 12;
}

TEST(OwnVehicle, IsWhereNoTrainingSweepHasAReturn) {
  const Scratch folder;
  Log log = log_of(folder, 20, 10.0, bonnet);
  const auto found = find_blind_arcs(log, {});
  ASSERT_EQ(found.size(), 1U);
  ASSERT_EQ(found[0].size(), 1U);
  EXPECT_EQ(found[0][0].row, 2);
  EXPECT_NEAR(found[0][0].azimuth_first, 5 * kStep_rad, 1e-12);
  EXPECT_NEAR(found[0][0].azimuth_last, 13 * kStep_rad, 1e-12);
  EXPECT_FALSE(found[0][0].own_returns);
  std::get<Lidar>(log.lidars[0].model).blind = found[0];
  EXPECT_NO_THROW(validate(log.lidars[0].model, "found"));
  EXPECT_TRUE(
      find_blind_arcs(log, {.held_out_every = 0})[0].empty());  // with the held-out sweeps there are returns
}

bool everywhere(int, int, int) { return true; }

TEST(OwnVehicle, IsWhatStaysInItsPlaceNearAndHigh) {
  const Scratch folder;
  const auto roof = [](int index, int row, int column) {
    const bool hits = row == 2 && column >= 5 && column <= 12;
    // At its end every second beam passes the roof.
    const bool passes = column == 12 && index % 2 == 0;
    return hits && !passes ? 1.0 + 0.02 * (index % 3) : 1.8 / std::sin(row == 2 ? 0.4 : 0.2);
  };
  const Log log = log_of(folder, 20, 1.0, everywhere, roof);  // 2 m suffice
  const auto found = find_blind_arcs(log, {});
  ASSERT_EQ(found[0].size(), 1U);
  EXPECT_EQ(found[0][0].row, 2);
  EXPECT_NEAR(found[0][0].azimuth_first, 5 * kStep_rad, 1e-12);
  EXPECT_NEAR(found[0][0].azimuth_last, 13 * kStep_rad, 1e-12);
  EXPECT_TRUE(found[0][0].own_returns);
}

TEST(OwnVehicle, IsNeitherNearGroundNorWhatDrivesBeside) {
  const std::vector<std::pair<const char*, Ranges>> cases{
      {"a low sensor's ground", [](int, int row, int) { return 1.0 / std::sin(row == 2 ? 0.4 : 0.2); }},
      {"a truck beside",
       [](int index, int row, int column) {
         return row == 2 && column < 9 ? 1.0 + 0.1 * (index % 9) : 1.8 / std::sin(row == 2 ? 0.4 : 0.2);
       }},
      {"a wall beside the path",  // 2.6 m to the left
       [](int, int row, int column) {
         return row == 2 && column > 7 && column < 10 ? 2.9 : 7.0 / std::sin(row == 2 ? 0.4 : 0.2);
       }},
      {"farther than its length", [](int, int row, int column) {
         return row == 2 && column < 9 ? 3.1 : 7.0 / std::sin(row == 2 ? 0.4 : 0.2);
       }}};
  for (const auto& [name, range_m] : cases) {
    SCOPED_TRACE(name);
    const Scratch folder;
    EXPECT_TRUE(find_blind_arcs(log_of(folder, 20, 10.0, everywhere, range_m), {})[0].empty());
  }
}

TEST(OwnVehicle, OneReturnOpensACell) {
  const Scratch folder;
  const Log log = log_of(folder, 20, 10.0, [](int index, int row, int column) {
    return bonnet(index, row, column) || (index == 7 && column == 8);
  });
  const auto found = find_blind_arcs(log, {});
  ASSERT_EQ(found[0].size(), 2U);
  EXPECT_NEAR(found[0][0].azimuth_last, 8 * kStep_rad, 1e-12);
  EXPECT_NEAR(found[0][1].azimuth_first, 9 * kStep_rad, 1e-12);
}

TEST(OwnVehicle, IsNotToldFromAFewSweepsOrAtRest) {
  const Scratch folder;
  EXPECT_TRUE(find_blind_arcs(log_of(folder, 8, 30.0, bonnet), {})[0].empty());
  EXPECT_TRUE(find_blind_arcs(log_of(folder, 20, 1.0, bonnet), {})[0].empty());
}

}  // namespace
}  // namespace simuli
