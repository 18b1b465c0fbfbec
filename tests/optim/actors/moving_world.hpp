#pragma once
// A road between walls with static and moving boxes, scanned from a moving rig: logs with known motion.
#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "io/log/log.hpp"

namespace simuli::test {

/// A box that may move; its origin is the centre of its base.
struct WorldBox {
  Eigen::Vector3d size_m;
  std::function<Pose(double time_s)> world_from_box;
  bool drives = true;
};

[[nodiscard]] WorldBox standing_box(const Eigen::Vector3d& size_m, const Eigen::Vector3d& base_m);

/// Pose of a body at a time: on the ground, rotated about z.
using Motion2d = std::function<Pose(double time_s)>;
/// Returns a car of 4.2 x 1.8 x 1.5 m: body, cabin and mirrors.
[[nodiscard]] std::vector<WorldBox> car(const Motion2d& world_from_car);
/// Returns its label: a key every 0.1 s, centred in the box.
[[nodiscard]] Actor label_of(const Eigen::Vector3d& size_m, const Motion2d& world_from_body, double end_s);

struct MovingWorld {
  std::vector<WorldBox> boxes;  // in addition to road, walls, poles and parked cars
  int sweeps = 24;              // at 10 Hz
  double speed_m_per_s = 4.0;   // of the rig, along x
};

/// Writes the log: a LiDAR of 64 beams and 720 columns 1.8 m above the road, no camera.
[[nodiscard]] Log write_world(const MovingWorld& world, const std::filesystem::path& folder);

}  // namespace simuli::test
