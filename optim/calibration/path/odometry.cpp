#include "optim/calibration/path/odometry.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <fmt/format.h>
#include <unordered_map>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/linear_algebra.hpp"
#include "host/core/base/parallel.hpp"
#include "optim/calibration/path/refine.hpp"
#include "optim/calibration/path/residuals.hpp"

namespace simuli::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kFewestReturns = 500;
constexpr std::size_t kFewestMatches = 100;
constexpr std::size_t kSolvedTogether = 4;  // first sweeps solved jointly
/// Normals of planes are accurate to 2 or 3 hundredths of a rad: below the square of three times that, an
/// apparent constraint is noise.
constexpr double kLeastShare = 0.005;

std::size_t stride_of(const Returns& returns, const OdometryOptions& options) {
  return std::max<std::size_t>(1, returns.size() / options.points_per_sweep);
}

/// Largest distance of points to their plane: decreasing over the iterations.
struct Gate {
  double first_m;
  double last_m;
  int iterations;
  [[nodiscard]] double at(int i) const {
    return std::max(last_m, first_m * std::pow(last_m / first_m, i / std::max(1.0, iterations / 2.0)));
  }
};

struct Match {
  std::uint32_t point;
  int plane;
};

struct Registration {
  TimedPose start;
  TimedPose end;
  double score = 0.0;  // sum over points of 1 on a plane, decreasing to 0 at kOutlier_m
  std::vector<Match> matches;
};

[[nodiscard]] Pose at(const TimedPose& start, const TimedPose& end, double time_s) {
  return interpolate(start.pose, end.pose, (time_s - start.time_s) / (end.time_s - start.time_s));
}

/// Every `stride`-th return with a plane within gate_m, at most kPerPlane per plane so that near surfaces do
/// not dominate.
std::vector<Match> match(const Returns& returns,
                         std::size_t stride,
                         const PlaneMap& map,
                         const Registration& guess,
                         double gate_m) {
  constexpr int kPerPlane = 4;
  std::vector<int> plane_of(returns.size() / stride, -1);
  parallel_each(plane_of.size(), [&](std::size_t i) {
    const Vector3d p = at(guess.start, guess.end, returns.time_s[i * stride]) * returns.p_rig[i * stride];
    const int found = map.find(p);
    if (found < 0) return;
    const Plane& plane = map.plane(found);
    if (std::abs(plane.normal.dot(p - plane.centre)) <= gate_m) plane_of[i] = found;
  });
  std::unordered_map<int, int> taken;
  std::vector<Match> matches;
  for (std::size_t i = 0; i < plane_of.size(); ++i) {
    if (plane_of[i] < 0 || taken[plane_of[i]]++ >= kPerPlane) continue;
    matches.push_back({static_cast<std::uint32_t>(i * stride), plane_of[i]});
  }
  return matches;
}

/// One Gauss-Newton round with fixed matches; returns the larger move (m, and rad x 10 m).
double solve(
    const Returns& returns, const PlaneMap& map, double loss_m, const TimedPose& before, Registration& r) {
  PoseBlock start(r.start.pose);
  PoseBlock end(r.end.pose);
  ceres::Problem problem;
  for (PoseBlock* block : {&start, &end}) {
    problem.AddParameterBlock(block->data(), PoseBlock::kSize, new PoseBlock::Manifold);
  }
  auto* const loss = new ceres::CauchyLoss(loss_m / kPointSigma_m);  // owned by the problem
  const double span_s = r.end.time_s - r.start.time_s;
  for (const Match& m : r.matches) {
    const Plane& plane = map.plane(m.plane);
    const double u = (returns.time_s[m.point] - r.start.time_s) / span_s;
    problem.AddResidualBlock(new PointOnPlane(returns.p_rig[m.point],
                                              u,
                                              plane.centre,
                                              plane.normal,
                                              std::hypot(kPointSigma_m, plane.thickness_m)),
                             loss,
                             start.data(),
                             end.data());
  }
  // Continuity: the sweep starts near the end of the one before.
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PosePrior, 6, PoseBlock::kSize>(
                               new PosePrior{PoseBlock(before.pose), 0.05 * kDegree, 0.01}),
                           nullptr,
                           start.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 4;
  options.function_tolerance = 1e-5;
  options.num_threads = 1;  // fixed summation order
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  double moved = 0.0;
  for (const auto& [block, pose] : {std::pair{&start, &r.start}, std::pair{&end, &r.end}}) {
    const Pose next = block->pose();
    moved = std::max({moved,
                      (next.translation - pose->pose.translation).norm(),
                      10.0 * next.rotation.angularDistance(pose->pose.rotation)});
    pose->pose = next;
  }
  return moved;
}

Registration register_sweep(const Returns& returns,
                            std::size_t stride,
                            const PlaneMap& map,
                            const TimedPose& start,
                            const TimedPose& end,
                            const Gate& gate) {
  constexpr double kSettled = 2e-4;
  Registration r{start, end, 0.0, {}};
  for (int i = 0; i < gate.iterations; ++i) {
    const double gate_m = gate.at(i);
    r.matches = match(returns, stride, map, r, gate_m);
    if (r.matches.size() < kFewestMatches) break;
    const double moved = solve(returns, map, std::max(0.03, gate_m / 3.0), start, r);
    if (moved < kSettled && gate_m <= gate.last_m) break;
  }
  r.matches = match(returns, stride, map, r, Fit::kOutlier_m);
  for (const Match& m : r.matches) {
    const Plane& plane = map.plane(m.plane);
    const Vector3d p = at(r.start, r.end, returns.time_s[m.point]) * returns.p_rig[m.point];
    const double share = plane.normal.dot(p - plane.centre) / Fit::kOutlier_m;
    r.score += 1.0 - share * share;
  }
  return r;
}

/// Adds every `stride`-th return.
void add_to_map(
    const Returns& returns, std::size_t stride, const TimedPose& start, const TimedPose& end, PlaneMap& map) {
  std::vector<Vector3d> p_world(returns.size() / stride);
  parallel_each(p_world.size(), [&](std::size_t i) {
    p_world[i] = at(start, end, returns.time_s[i * stride]) * returns.p_rig[i * stride];
  });
  for (const Vector3d& p : p_world) map.add(p);
  map.update();
}

/// Extrapolates `pose` with the velocity between `from` and `to` to time_s.
TimedPose continued(const TimedPose& from, const TimedPose& to, double time_s) {
  const double ratio = (time_s - to.time_s) / (to.time_s - from.time_s);
  const Pose step = from.pose.inverse() * to.pose;
  return {
      time_s,
      to.pose * Pose{Eigen::Quaterniond::Identity().slerp(ratio, step.rotation), ratio * step.translation}};
}

/// Finds the first sweep's motion by testing forward speeds: the one with which the second sweep fits the
/// first.
TimedPose first_motion(const std::vector<Returns>& sweeps,
                       const std::vector<double>& knots_s,
                       const OdometryOptions& options) {
  constexpr double kStep_m = 0.2;  // per sweep; registration refines
  const TimedPose origin{knots_s[0], Pose{}};
  const double span_s = knots_s[1] - knots_s[0];
  const auto try_motion = [&](const TimedPose& end, const Gate& gate) {
    PlaneMap map;
    add_to_map(sweeps[0], 2, origin, end, map);
    const TimedPose start{sweeps[1].time_start_s, end.pose};
    const TimedPose next = continued(origin, end, sweeps[1].time_end_s);
    return register_sweep(sweeps[1], 2 * stride_of(sweeps[1], options), map, start, next, gate);
  };
  Registration best;
  const int steps = static_cast<int>(std::ceil(options.fastest_m_per_s * span_s / kStep_m));
  for (int i = 0; i <= steps; ++i) {
    const TimedPose end{knots_s[1], {Eigen::Quaterniond::Identity(), {kStep_m * i, 0.0, 0.0}}};
    const Registration r = try_motion(end, {0.3, 0.1, 5});
    if (r.score > best.score) best = r;
  }
  if (best.matches.size() < kFewestMatches) {
    throw Error(
        ErrorKind::kNumeric,
        fmt::format("sweep 1: found {} of its points on surfaces of sweep 0 at any speed up to {} m/s, "
                    "allowed at least {}",
                    best.matches.size(),
                    options.fastest_m_per_s,
                    kFewestMatches));
  }
  TimedPose end{knots_s[1], {}};
  for (int round = 0; round < 3; ++round) {
    const Pose step = best.start.pose.inverse() * best.end.pose;
    const double ratio = span_s / (best.end.time_s - best.start.time_s);
    end.pose = {Eigen::Quaterniond::Identity().slerp(ratio, step.rotation), ratio * step.translation};
    best = try_motion(end, {0.3, 0.1, options.iterations});
  }
  return end;
}

/// An error of the first sweep's assumed motion bends the map and all later sweeps. Solving the first sweeps
/// jointly removes it.
void solve_together(const std::vector<Returns>& sweeps,
                    std::size_t count,
                    std::vector<TimedPose>& path,
                    PlaneMap& map) {
  const std::vector<Returns> first(sweeps.begin(), sweeps.begin() + static_cast<std::ptrdiff_t>(count));
  (void)refine_path(first, {}, {}, path);
  map = {};
  for (const Returns& sweep : first) {
    const std::size_t segment = segment_of(path, 0.5 * (sweep.time_start_s + sweep.time_end_s));
    add_to_map(sweep, 1, path[segment], path[segment + 1], map);
  }
}

void require_constraint(const Returns& returns,
                        const PlaneMap& map,
                        const Registration& r,
                        std::size_t number,
                        const char* unit) {
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::kNumeric, fmt::format("{} {}: {}", unit, number, why));
  };
  if (r.matches.size() < kFewestMatches) {
    refuse(fmt::format(
        "found {} points on known surfaces, allowed at least {}", r.matches.size(), kFewestMatches));
  }
  std::vector<Vector3d> p_rig;
  std::vector<Vector3d> normal_rig;
  for (const Match& m : r.matches) {
    p_rig.push_back(returns.p_rig[m.point]);
    normal_rig.push_back(r.start.pose.rotation.conjugate() * map.plane(m.plane).normal);
  }
  const Constraint c = constraint_of(p_rig, normal_rig);
  const auto text = [](const Vector3d& v) {
    return fmt::format("({:.2f}, {:.2f}, {:.2f})", v.x(), v.y(), v.z());
  };
  if (!(c.least_shift >= kLeastShare)) {
    refuse(
        fmt::format("its surfaces do not determine the motion along {} of the rig: they face that way by "
                    "{:.4f} (mean square cosine), allowed at least {}",
                    text(c.shift_direction),
                    c.least_shift,
                    kLeastShare));
  }
  if (!(c.least_turn >= kLeastShare)) {
    refuse(
        fmt::format("its surfaces do not determine the turn about {} of the rig: {:.4f}, allowed at least {}",
                    text(c.turn_axis),
                    c.least_turn,
                    kLeastShare));
  }
}

/// Of the two directions of an axis, the one with a positive largest component.
Vector3d signed_axis(const Vector3d& axis) {
  Eigen::Index largest = 0;
  (void)axis.cwiseAbs().maxCoeff(&largest);
  return axis[largest] < 0.0 ? Vector3d(-axis) : axis;
}

}  // namespace

std::vector<double> knot_times(const std::vector<Returns>& sweeps) {
  constexpr double kPause = 0.01;
  std::vector<double> knots;
  for (std::size_t i = 0; i < sweeps.size(); ++i) {
    const Returns& sweep = sweeps[i];
    const double span_s = sweep.time_end_s - sweep.time_start_s;
    if (!knots.empty() && !(sweep.time_start_s > knots.back())) {
      throw_input_error(fmt::format("sweep {}", i),
                        "start",
                        fmt::format("{} s", sweep.time_start_s),
                        fmt::format("after {} s, one sweep behind the other", knots.back()));
    }
    knots.push_back(sweep.time_start_s);
    const bool last = i + 1 == sweeps.size();
    if (last || sweeps[i + 1].time_start_s - sweep.time_end_s > kPause * span_s)
      knots.push_back(sweep.time_end_s);
  }
  return knots;
}

std::size_t segment_of(const std::vector<TimedPose>& path, double time_s) {
  const auto next = std::upper_bound(
      path.begin(), path.end(), time_s, [](double t, const TimedPose& p) { return t < p.time_s; });
  return static_cast<std::size_t>(std::clamp(next, path.begin() + 1, path.end() - 1) - path.begin()) - 1;
}

Vector3d world_point(const std::vector<TimedPose>& path, const Vector3d& p_rig, double time_s) {
  const std::size_t i = segment_of(path, time_s);
  return at(path[i], path[i + 1], time_s) * p_rig;
}

Constraint constraint_of(const std::vector<Vector3d>& p_rig, const std::vector<Vector3d>& normal_rig) {
  Constraint out;
  if (p_rig.empty()) return out;
  const auto count = static_cast<double>(p_rig.size());
  double square_range = 0.0;
  for (const Vector3d& p : p_rig) square_range += p.squaredNorm() / count;
  Matrix3d shift = Matrix3d::Zero();
  Matrix3d turn = Matrix3d::Zero();
  Matrix3d mixed = Matrix3d::Zero();  // rows: rotation
  for (std::size_t i = 0; i < p_rig.size(); ++i) {
    const Vector3d arm = p_rig[i].cross(normal_rig[i]) / std::sqrt(square_range);
    shift += normal_rig[i] * normal_rig[i].transpose() / count;
    turn += arm * arm.transpose() / count;
    mixed += arm * normal_rig[i].transpose() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> shifts(shift);
  out.least_shift = shifts.eigenvalues()[0];
  out.shift_direction = signed_axis(shifts.eigenvectors().col(0));
  // Information of rotations alone, after marginalising shifts.
  const Matrix3d left = turn - mixed * pseudo_inverse(shift) * mixed.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> turns(left);
  out.least_turn = turns.eigenvalues()[0];
  out.turn_axis = signed_axis(turns.eigenvectors().col(0));
  return out;
}

std::vector<TimedPose> find_path(const std::vector<Returns>& sweeps,
                                 const OdometryOptions& options,
                                 const std::function<void(std::size_t, std::size_t)>& progress) {
  if (sweeps.size() < 2) {
    throw Error(ErrorKind::kNumeric, fmt::format("sweeps: found {}, allowed at least 2", sweeps.size()));
  }
  for (std::size_t i = 0; i < sweeps.size(); ++i) {
    if (sweeps[i].size() >= kFewestReturns) continue;
    throw Error(
        ErrorKind::kNumeric,
        fmt::format("sweep {}: found {} returns, allowed at least {}", i, sweeps[i].size(), kFewestReturns));
  }
  const std::vector<double> knots_s = knot_times(sweeps);
  std::vector<TimedPose> path{{knots_s[0], Pose{}}, first_motion(sweeps, knots_s, options)};
  PlaneMap map;
  add_to_map(sweeps[0], 1, path[0], path[1], map);
  if (progress) progress(1, sweeps.size());
  for (std::size_t i = 1; i < sweeps.size(); ++i) {
    const Returns& sweep = sweeps[i];
    while (path.back().time_s < sweep.time_start_s) {
      const std::size_t last = path.size() - 1;
      path.push_back(continued(path[last - 1], path[last], knots_s[path.size()]));
    }
    const std::size_t last = path.size() - 1;
    const TimedPose end = continued(path[last - 1], path[last], knots_s[path.size()]);
    const Registration r = register_sweep(
        sweep, stride_of(sweep, options), map, path[last], end, {0.4, 0.1, options.iterations});
    require_constraint(sweep, map, r, i, "sweep");
    path[last] = r.start;
    path.push_back(r.end);
    if (i + 1 == kSolvedTogether) {
      solve_together(sweeps, i + 1, path, map);
    } else {
      add_to_map(sweep, 1, r.start, r.end, map);
    }
    if (progress) progress(i + 1, sweeps.size());
  }
  return path;
}

}  // namespace simuli::calibration
