#pragma once
// Static surfaces that occlude but return nothing: glass and black paint of parked cars, shop windows. They
// have no returns, but drop rays that the ground behind them would have returned.
#include <cstdint>
#include <memory>
#include <vector>

#include "host/core/scene/ground/ground_map.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// Space occupied by a moving object during a sweep, centred on the object's frame.
struct MovingBox {
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  // m
  Pose scene_from_box_start;  // at the start of the sweep
  Pose scene_from_box_end;
};

/// Votes of all sweeps' rays in voxels above the ground. Add the dropped rays of all sweeps first, then the
/// returned rays of all sweeps.
class DarkStill {
 public:
  /// `ground` must outlive this object.
  DarkStill(const GroundMap& ground, double voxel_m);
  ~DarkStill();

  /// Adds dropped rays that would hit known ground within kGround_m. Ignores rays in blind arcs and rays
  /// through any of `boxes`, which moving objects may have absorbed.
  void add_dropped(const PosedSweep& posed, const std::vector<MovingBox>& boxes = {});
  /// Adds returned rays, which passed the space in front of their return.
  void add_returned(const PosedSweep& posed);
  /// Returns the first dark voxels (DarkVotes) along dropped rays: one point per voxel, with intensity 0.
  [[nodiscard]] PointSet points() const;

  static constexpr double kGround_m = 25.0;  // within this distance even asphalt returns
  static constexpr double kHeight_m = 2.2;  // largest height above the ground

  DarkStill(const DarkStill&) = delete;
  DarkStill& operator=(const DarkStill&) = delete;

 private:
  struct Votes;
  /// Segment of a ray, m from its origin: from its entry into the low space above the ground to the ground.
  struct Way {
    Eigen::Vector3d origin, direction;
    double from_m = 0.0, to_m = 0.0;
  };
  const GroundMap& ground_;
  std::unique_ptr<Votes> votes_;
  std::vector<Way> dropped_;
};

}  // namespace simuli
