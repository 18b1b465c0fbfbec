#include "optim/calibration/camera/mounting_problem.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/parallel.hpp"
#include "optim/calibration/path/odometry.hpp"

namespace simuli::calibration {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSmooth_px = 1.0;
constexpr std::size_t kFewestMatches = 300;
constexpr double kPictureSigma_px = 0.4;  // of edge positions in pictures
constexpr double kPriorTranslation_m = 0.3;
constexpr double kPriorRotation_rad = 5.0 * kDegree;
constexpr double kPriorTime_s = 0.05;

/// Ranges [first, last) of edges (sorted by time) within `about_s` of each view: [views].
std::vector<std::pair<std::size_t, std::size_t>> edges_of_views(const std::vector<CameraView>& views,
                                                                const std::vector<DepthEdge>& edges,
                                                                double about_s) {
  std::vector<std::pair<std::size_t, std::size_t>> ranges;
  const auto place = [&](double time_s) {
    const auto found = std::lower_bound(
        edges.begin(), edges.end(), time_s, [](const DepthEdge& e, double t) { return e.time_s < t; });
    return static_cast<std::size_t>(found - edges.begin());
  };
  for (const CameraView& view : views) {
    ranges.emplace_back(place(view.exposure_start_s - about_s), place(view.exposure_end_s + about_s));
  }
  return ranges;
}

struct TimePrior {
  template <class T>
  bool operator()(const T* time_offset, T* out) const {
    out[0] = time_offset[0] / T(kPriorTime_s);
    return true;
  }
};

}  // namespace

double distance_px(const PointOnLine& line, const MountingState& state) {
  double error = 0.0;
  const bool seen = line(state.rig_from_camera.data(), &state.time_offset_s, &error);
  return seen ? std::abs(error) * line.sigma_px : INFINITY;
}

EdgeMatcher::EdgeMatcher(const std::vector<CameraView>& views,
                         const LogCamera& camera,
                         const Trajectory& world_from_rig,
                         const std::vector<DepthEdge>& edges,
                         const CameraPoseOptions& options)
    : views_(views),
      camera_(camera),
      jet_camera_(camera.model),
      path_(world_from_rig),
      edges_(edges),
      least_strength_(options.least_strength),
      ranges_(edges_of_views(views, edges, options.sweeps_about_s)) {
  for (const CameraView& view : views) edge_images_.emplace_back(view.picture, kSmooth_px);
  for (const DepthEdge& edge : edges) {
    const Pose world_from_rig_then = world_from_rig.at(edge.time_s);
    p_world_.push_back(world_from_rig_then * edge.p_rig);
    across_world_.push_back(world_from_rig_then.rotation * edge.across);
  }
}

std::vector<Match> EdgeMatcher::find(const MountingState& state, double reach_px) const {
  std::vector<Match> matches;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const auto [first, last] = ranges_[v];
    const std::size_t before = matches.size();
    matches.resize(before + last - first);
    parallel_each(
        last - first,
        [&, from = first](std::size_t i) { matches[before + i] = find_one(v, from + i, state, reach_px); },
        256);
  }
  const auto found = static_cast<std::size_t>(
      std::count_if(matches.begin(), matches.end(), [](const Match& m) { return m.found; }));
  if (found < kFewestMatches) {
    throw Error(
        ErrorKind::kNumeric,
        fmt::format("mounting of camera {}: not determined, found {} depth edges that lie on edges of "
                    "{} pictures, allowed at least {} (a blank wall has none)",
                    camera_.model.name,
                    found,
                    views_.size(),
                    kFewestMatches));
  }
  return matches;
}

Match EdgeMatcher::find_one(std::size_t v, std::size_t e, const MountingState& state, double reach_px) const {
  Match match;
  const CameraView& view = views_[v];
  const DepthEdge& edge = edges_[e];
  const Vector3d& p_world = p_world_[e];
  const Vector3d& across_world = across_world_[e];
  const Camera& model = camera_.model;
  const Pose rig_from_camera = state.rig_from_camera.pose();
  double fraction = 0.5;
  double time_s = 0.0;
  Vector2d pixel;
  Pose camera_from_world;
  // Rolling-shutter rows have their own times: two iterations suffice for 20 ms.
  for (int k = 0; k < 2; ++k) {
    time_s = view.exposure_start_s + fraction * (view.exposure_end_s - view.exposure_start_s);
    camera_from_world = (pose_near(path_, time_s + state.time_offset_s) * rig_from_camera).inverse();
    if (!model.project(camera_from_world * p_world, pixel)) return match;
    fraction = std::clamp(model.exposure_fraction(pixel), 0.0, 1.0);
  }
  constexpr double kMargin_px = 3.0;
  if (!(pixel.x() >= kMargin_px && pixel.y() >= kMargin_px && pixel.x() <= model.width - kMargin_px &&
        pixel.y() <= model.height - kMargin_px && edge_images_[v].is_open(pixel))) {
    return match;
  }
  Vector2d outside;
  if (!model.project(camera_from_world * (p_world + edge.half_width * across_world), outside)) return match;
  const double width_px = (outside - pixel).norm();
  if (!(width_px > 1e-6)) return match;
  match.in_view = true;
  EdgeImage::Edge seen;
  if (!edge_images_[v].find(pixel, (outside - pixel) / width_px, reach_px, least_strength_, seen)) {
    return match;
  }
  match.found = true;
  const std::vector<TimedPose>& knots = path_.poses();
  const std::size_t segment = segment_of(knots, time_s + state.time_offset_s);
  match.line = {&jet_camera_,
                p_world,
                knots[segment],
                knots[segment + 1],
                time_s,
                seen.pixel,
                seen.normal,
                std::hypot(kPictureSigma_px, width_px / std::sqrt(3.0))};
  return match;
}

MountingProblem::MountingProblem(const std::vector<Match>& matches,
                                 const MountingState& given,
                                 double loss,
                                 bool with_time,
                                 MountingState& state)
    : state_(state) {
  double* const mounting = state.rig_from_camera.data();
  problem_.AddParameterBlock(mounting, PoseBlock::kSize, new PoseBlock::Manifold);
  problem_.AddParameterBlock(&state.time_offset_s, 1);
  auto* const cauchy = new ceres::CauchyLoss(loss);
  for (const Match& match : matches) {
    if (!match.found) continue;
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PointOnLine, 1, PoseBlock::kSize, 1>(new PointOnLine(match.line)),
        cauchy,
        mounting,
        &state.time_offset_s);
  }
  problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PosePrior, 6, PoseBlock::kSize>(new PosePrior{
                                given.rig_from_camera, kPriorRotation_rad, kPriorTranslation_m}),
                            nullptr,
                            mounting);
  if (with_time) {
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<TimePrior, 1, 1>(new TimePrior), nullptr, &state.time_offset_s);
  } else {
    problem_.SetParameterBlockConstant(&state.time_offset_s);
  }
}

void MountingProblem::solve() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 15;
  options.num_threads = 1;  // fixed summation order
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_, &summary);
  if (!summary.IsSolutionUsable()) {
    throw Error(ErrorKind::kNumeric, "mounting of the camera: " + summary.message);
  }
}

Eigen::MatrixXd MountingProblem::covariance(bool with_time) {
  ceres::Covariance::Options how;
  how.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance covariance(how);
  std::vector<const double*> blocks{state_.rig_from_camera.data()};
  if (with_time) blocks.push_back(&state_.time_offset_s);
  const Eigen::Index size = with_time ? 7 : 6;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> out(size, size);
  if (!covariance.Compute(blocks, &problem_) ||
      !covariance.GetCovarianceMatrixInTangentSpace(blocks, out.data())) {
    throw Error(ErrorKind::kNumeric, "mounting of the camera: its covariance is not finite");
  }
  return out;
}

}  // namespace simuli::calibration
