#pragma once
// Steps of find_camera_pose(): search of depth edges in the pictures, and the mounting that aligns them.
#include <Eigen/Core>
#include <ceres/problem.h>
#include <cstddef>
#include <utility>
#include <vector>

#include "io/log/log.hpp"
#include "optim/calibration/camera/camera_edges.hpp"
#include "optim/calibration/camera/camera_pose.hpp"
#include "optim/calibration/camera/camera_residual.hpp"

namespace simuli::calibration {

/// A depth edge in one picture.
struct Match {
  PointOnLine line;
  bool found = false;
  bool in_view = false;
};

/// Unknowns: a camera's mounting and its clock.
struct MountingState {
  PoseBlock rig_from_camera;
  double time_offset_s = 0.0;
};

/// Distance of a match, px; infinite when the camera does not see the point.
[[nodiscard]] double distance_px(const PointOnLine& line, const MountingState& state);

/// Finds the depth edges near each view in time in its picture. Its inputs must outlive it.
class EdgeMatcher {
 public:
  EdgeMatcher(const std::vector<CameraView>& views,
              const LogCamera& camera,
              const Trajectory& world_from_rig,
              const std::vector<DepthEdge>& edges,
              const CameraPoseOptions& options);
  /// Searches each edge, view by view, within `reach_px` of its projection by `state`. Throws Error{kNumeric}
  /// when too few are found.
  [[nodiscard]] std::vector<Match> find(const MountingState& state, double reach_px) const;

 private:
  [[nodiscard]] Match find_one(std::size_t view,
                               std::size_t edge,
                               const MountingState& state,
                               double reach_px) const;

  const std::vector<CameraView>& views_;
  const LogCamera& camera_;
  JetCamera jet_camera_;
  const Trajectory& path_;
  const std::vector<DepthEdge>& edges_;
  double least_strength_;
  std::vector<std::pair<std::size_t, std::size_t>> ranges_;  // [views] of [first, last) into the edges
  std::vector<EdgeImage> edge_images_;                       // [views]
  std::vector<Eigen::Vector3d> p_world_, across_world_;      // [edges]
};

/// Solves for mounting and clock from matches, near the given values.
class MountingProblem {
 public:
  /// Starts at `state` and changes it; `loss` in sigmas.
  MountingProblem(const std::vector<Match>& matches,
                  const MountingState& given,
                  double loss,
                  bool with_time,
                  MountingState& state);
  /// Throws Error{kNumeric} without solution.
  void solve();
  /// Half-angles about the rig's axes, position on the rig, clock: [7 x 7], or 6 without a clock. Throws
  /// Error{kNumeric} when it is not finite.
  [[nodiscard]] Eigen::MatrixXd covariance(bool with_time);

 private:
  MountingState& state_;
  ceres::Problem problem_;
};

}  // namespace simuli::calibration
