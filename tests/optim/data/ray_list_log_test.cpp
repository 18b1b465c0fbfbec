// Tests a log with a ray list: written, read, initialised, trained and evaluated.
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <variant>

#include "optim/data/sensor_learning.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/train/training.hpp"
#include "tests/optim/small_street.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

/// Returns the rays of the street's LiDAR ahead of the vehicle, in another order.
RayList ahead_of(const Lidar& lidar) {
  RayList list;
  list.name = "ahead";
  list.range_min = lidar.range_min;
  list.range_max = lidar.range_max;
  const LidarRays rays = nominal_rays(lidar);
  for (std::size_t k = 0; k < rays.azimuth.size(); ++k) {
    const std::size_t i = k * 7 % rays.azimuth.size();  // 7 divides no such grid: a permutation
    if (std::abs(rays.azimuth[i]) > 1.2F) continue;
    list.azimuth.push_back(rays.azimuth[i]);
    list.elevation.push_back(rays.elevation[i]);
    list.time_fraction.push_back(0.3 +
                                 0.4 * static_cast<double>(k) / static_cast<double>(rays.azimuth.size()));
    list.origin.push_back(ray_origin(lidar, rays, i));
  }
  return list;
}

class RayListLog : public test::SmallStreet {
 protected:
  /// Returns the street's log with sweeps of the ray list.
  static Log listed() {
    Log log = log_;
    log.images.clear();
    log.lidars = {{ahead_of(log_.lidars[0].with_rows()), log_.lidars[0].rig_from_lidar}};
    log.folder = folder_ / "listed.log";
    std::filesystem::create_directories(log.folder / "sweeps");
    const Street street({.car = std::nullopt});
    for (SweepFrame& f : log.sweeps) {
      f.lidar = "ahead";
      write_sweep(log.folder / f.file,
                  scan_street(street, log.lidars[0], log.world_from_rig, f.time_start_s, f.time_end_s));
    }
    write_log(log);
    return with_blind_arcs(read_log(log.folder), {});
  }
};

TEST_F(RayListLog, IsTrainedAndComparedLikeAnyOther) {
  const Log log = listed();
  const auto& list = std::get<RayList>(log.lidars.at(0).model);
  ASSERT_GT(list.ray_count(), 500U);
  TrainingOptions options;
  options.init.voxel_m = 0.2;
  options.init.sweep_depth = false;
  options.train.iterations = 40;
  const Device& device = test::device();
  Training training(device, log, options);
  training.run();
  const EvalReport report = Evaluation(device, training.result(), log).run();
  EXPECT_EQ(report.sweeps, 1U);
  EXPECT_LT(report.lidar.distance_median_m, 0.1);
  EXPECT_GT(report.lidar.raydrop_accuracy, 0.8);
}

}  // namespace
}  // namespace simuli
