#pragma once
// Surfaces that stand still, are in rays' way and send nothing back: glass and black paint of parked cars,
// shop windows. No return tells of them, but rays that drop although the ground would have answered them do.
#include <cstdint>
#include <memory>
#include <vector>

#include "host/core/scene/ground/ground_map.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// Room that something on the move takes up while a sweep is taken, centred on its own frame.
struct MovingBox {
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  // m
  Pose scene_from_box_start;                       // as the sweep begins
  Pose scene_from_box_end;
};

/// What the rays of all sweeps say of the space above the ground, in voxels. First the rays that drop, of all
/// sweeps; then those that return, of all sweeps.
class DarkStill {
 public:
  /// `ground` must outlive it.
  DarkStill(const GroundMap& ground, double voxel_m);
  ~DarkStill();

  /// Rays that drop, and would meet ground that is known within kGround_m. Rays in blind arcs say nothing,
  /// nor do those that come through one of `boxes`: what drove there may have sent nothing back.
  void add_dropped(const PosedSweep& posed, const std::vector<MovingBox>& boxes = {});
  /// Rays that return came through all that lies before it.
  void add_returned(const PosedSweep& posed);
  /// Where rays that dropped first meet a dark voxel (DarkVotes). One point per voxel, of intensity 0.
  [[nodiscard]] PointSet points() const;

  static constexpr double kGround_m = 25.0;  // nearer even asphalt answers
  static constexpr double kHeight_m = 2.2;   // above the ground, of what is looked at

  DarkStill(const DarkStill&) = delete;
  DarkStill& operator=(const DarkStill&) = delete;

 private:
  struct Votes;
  /// Of a ray, m from its origin: from where it is low above the ground to where it would meet it.
  struct Way {
    Eigen::Vector3d origin, direction;
    double from_m = 0.0, to_m = 0.0;
  };
  const GroundMap& ground_;
  std::unique_ptr<Votes> votes_;
  std::vector<Way> dropped_;
};

}  // namespace simuli
