#include "optim/calibration/path/refine.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <ceres/ceres.h>
#include <ceres/crs_matrix.h>
#include <cmath>
#include <exception>
#include <fmt/format.h>
#include <map>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "host/core/base/linear_algebra.hpp"
#include "host/core/base/parallel.hpp"
#include "host/core/base/spread.hpp"
#include "optim/calibration/path/odometry.hpp"
#include "optim/calibration/path/residuals.hpp"

namespace simuli::calibration {
namespace {

using Eigen::Vector3d;

constexpr double kLoss_m = 0.03;
constexpr double kGate_m = 0.15;
constexpr std::size_t kFewestSweeps = 3;  // per plane

struct Observation {
  std::size_t segment;
  Vector3d p_rig;
  double u;
};

struct FreePlane {
  Plane plane;
  std::vector<Observation> observations;
  std::array<double, 3> change{0.0, 0.0, 0.0};
};

/// Planes of the map along `path`, with their points.
std::vector<FreePlane> find_planes(const std::vector<Returns>& sweeps,
                                   const std::vector<TimedPose>& path,
                                   std::size_t points_per_sweep) {
  constexpr std::size_t kStride = 2;  // planes have enough points
  constexpr int kPerSweep = 3;  // observations of one plane per sweep
  const auto stride_of = [&](const Returns& sweep) {
    return std::max<std::size_t>(1, sweep.size() / points_per_sweep);
  };
  PlaneMap map;
  for (const Returns& sweep : sweeps) {
    Interruption::ask();
    for (std::size_t i = 0; i < sweep.size(); i += kStride) {
      map.add(world_point(path, sweep.p_rig[i], sweep.time_s[i]));
    }
  }
  map.update();
  struct Members {
    std::vector<Observation> observations;
    std::size_t sweeps = 0;
    std::size_t last_sweep = 0;
    int of_sweep = 0;
  };
  std::map<int, Members> members;  // by plane index
  for (std::size_t s = 0; s < sweeps.size(); ++s) {
    const Returns& sweep = sweeps[s];
    Interruption::ask();
    for (std::size_t i = 0; i < sweep.size(); i += stride_of(sweep)) {
      const Vector3d p = world_point(path, sweep.p_rig[i], sweep.time_s[i]);
      const int number = map.find(p);
      if (number < 0) continue;
      const Plane& plane = map.plane(number);
      if (!(std::abs(plane.normal.dot(p - plane.centre)) <= kGate_m)) continue;
      Members& m = members[number];
      if (m.sweeps == 0 || m.last_sweep != s) {
        ++m.sweeps;
        m.of_sweep = 0;
      }
      m.last_sweep = s;
      if (m.of_sweep++ >= kPerSweep) continue;
      const std::size_t segment = segment_of(path, sweep.time_s[i]);
      const double from_s = path[segment].time_s;
      m.observations.push_back(
          {segment, sweep.p_rig[i], (sweep.time_s[i] - from_s) / (path[segment + 1].time_s - from_s)});
    }
  }
  std::vector<FreePlane> planes;
  for (auto& [number, m] : members) {
    if (m.sweeps < kFewestSweeps) continue;
    planes.push_back({map.plane(number), std::move(m.observations)});
  }
  return planes;
}

/// Checks for interruption; exceptions may not pass through the solver.
class Asking : public ceres::IterationCallback {
 public:
  [[nodiscard]] bool goes_on() {
    if (thrown_) return false;
    try {
      Interruption::ask();
    } catch (...) {
      thrown_ = std::current_exception();
    }
    return !thrown_;
  }
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return goes_on() ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
  }
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  std::exception_ptr thrown_;
};

/// Also checks during an iteration, which takes long.
class AskingPointOnPlane final : public PointOnFreePlane {
 public:
  template <class... Ts>
  explicit AskingPointOnPlane(Asking& asking, const Ts&... point)
      : PointOnFreePlane(point...), asking_(asking) {}
  bool Evaluate(double const* const* blocks, double* out, double** derivatives) const override {
    return asking_.goes_on() && PointOnFreePlane::Evaluate(blocks, out, derivatives);
  }

 private:
  Asking& asking_;
};

class JointProblem {
 public:
  JointProblem(std::vector<FreePlane>& planes,
               const std::vector<TimedPose>& path,
               const std::optional<PathPrior>& prior)
      : planes_(planes) {
    for (const TimedPose& knot : path) blocks_.emplace_back(knot.pose);
    for (PoseBlock& block : blocks_) {
      problem_.AddParameterBlock(block.data(), PoseBlock::kSize, new PoseBlock::Manifold);
    }
    auto* const loss = new ceres::CauchyLoss(kLoss_m / kPointSigma_m);
    for (FreePlane& plane : planes) {
      Interruption::ask();
      add(plane, loss);
    }
    if (prior) {
      auto* const prior_loss = new ceres::HuberLoss(2.0);
      for (std::size_t i = 0; i < path.size(); ++i) {
        const PoseBlock believed(prior->world_from_rig.at(path[i].time_s));
        problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PosePrior, 6, PoseBlock::kSize>(
                                      new PosePrior{believed, prior->sigma_rad, prior->sigma_m}),
                                  prior_loss,
                                  blocks_[i].data());
      }
    } else {
      problem_.SetParameterBlockConstant(blocks_[0].data());
    }
  }

  void solve(std::vector<TimedPose>& path) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.max_num_iterations = 8;
    options.function_tolerance = 1e-5;
    options.num_threads = 1;  // fixed summation order
    options.logging_type = ceres::SILENT;
    auto* const ordering = new ceres::ParameterBlockOrdering;
    for (FreePlane& plane : planes_) ordering->AddElementToGroup(plane.change.data(), 0);
    for (PoseBlock& block : blocks_) ordering->AddElementToGroup(block.data(), 1);
    options.linear_solver_ordering.reset(ordering);
    options.callbacks.push_back(&asking_);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    asking_.rethrow();
    if (!summary.IsSolutionUsable()) {
      throw Error(ErrorKind::kNumeric, "joint refinement of the path: " + summary.message);
    }
    for (std::size_t i = 0; i < path.size(); ++i) path[i].pose = blocks_[i].pose();
  }

  /// Computes sigma_m and the standard deviations of a step for the first kMostKnots knots: the inverse of the
  /// poses' information after marginalising all planes.
  void measure(RefineReport& report) {
    constexpr std::size_t kMostKnots = 120;
    const auto knots =
        static_cast<Eigen::Index>(std::min(blocks_.size(), kMostKnots)) - 1;  // the first is fixed
    ceres::Problem::EvaluateOptions what;
    for (Eigen::Index i = 1; i <= knots; ++i) {
      what.parameter_blocks.push_back(blocks_[static_cast<std::size_t>(i)].data());
    }
    for (FreePlane& plane : planes_) what.parameter_blocks.push_back(plane.change.data());
    what.apply_loss_function = false;
    std::vector<double> residuals;
    ceres::CRSMatrix jacobian;
    double cost = 0.0;
    problem_.Evaluate(what, &cost, &residuals, nullptr, &jacobian);
    asking_.rethrow();
    std::vector<double> sizes;
    for (const double r : residuals) sizes.push_back(std::abs(r));
    const double sigma = 1.4826 * upper_median(std::move(sizes));
    report.sigma_m = sigma * kPointSigma_m;

    const Eigen::Index size = 6 * knots;
    Eigen::MatrixXd poses = Eigen::MatrixXd::Zero(size, size);
    std::vector<Eigen::Matrix3d> planes(planes_.size(), Eigen::Matrix3d::Zero());
    std::vector<std::map<Eigen::Index, Vector3d>> mixed(planes_.size());  // by column of a pose
    for (int row = 0; row < jacobian.num_rows; ++row) {
      // Weight of the residual under the robust loss.
      const double share = residuals[static_cast<std::size_t>(row)] * kPointSigma_m / kLoss_m;
      const double weight = 1.0 / ((1.0 + share * share) * sigma * sigma);
      const auto first = static_cast<std::size_t>(jacobian.rows[static_cast<std::size_t>(row)]);
      const auto last = static_cast<std::size_t>(jacobian.rows[static_cast<std::size_t>(row) + 1]);
      for (std::size_t a = first; a < last; ++a) {
        for (std::size_t b = first; b < last; ++b) {
          const Eigen::Index i = jacobian.cols[a];
          const Eigen::Index j = jacobian.cols[b];
          const double value = weight * jacobian.values[a] * jacobian.values[b];
          if (i < size && j < size) {
            poses(i, j) += value;
          } else if (i >= size && j >= size) {
            planes[static_cast<std::size_t>((i - size) / 3)]((i - size) % 3, (j - size) % 3) += value;
          } else if (i >= size) {
            const auto place =
                mixed[static_cast<std::size_t>((i - size) / 3)].try_emplace(j, Vector3d::Zero()).first;
            place->second[(i - size) % 3] += value;
          }
        }
      }
    }
    for (std::size_t p = 0; p < planes.size(); ++p) {
      const Eigen::Matrix3d inverse = pseudo_inverse(planes[p]);
      for (const auto& [i, left] : mixed[p]) {
        const Eigen::RowVector3d through = left.transpose() * inverse;
        for (const auto& [j, right] : mixed[p]) poses(i, j) -= through.dot(right);
      }
    }
    const Eigen::MatrixXd covariance = poses.ldlt().solve(Eigen::MatrixXd::Identity(size, size));
    double turn = 0.0;  // sums of variances over axes
    double shift = 0.0;
    for (Eigen::Index k = 1; k < knots; ++k) {
      const Eigen::Index here = 6 * k;
      const Eigen::Index before = here - 6;
      const Eigen::Matrix<double, 6, 6> step =
          covariance.block<6, 6>(here, here) + covariance.block<6, 6>(before, before) -
          covariance.block<6, 6>(here, before) - covariance.block<6, 6>(before, here);
      turn += 4.0 * step.topLeftCorner<3, 3>().trace();  // Ceres rotates by half-angles
      shift += step.bottomRightCorner<3, 3>().trace();
    }
    const double count = 3.0 * static_cast<double>(std::max<Eigen::Index>(1, knots - 1));
    report.step_sigma_rad = std::sqrt(turn / count);
    report.step_sigma_m = std::sqrt(shift / count);
  }

 private:
  void add(FreePlane& plane, ceres::LossFunction* loss) {
    for (const Observation& seen : plane.observations) {
      problem_.AddResidualBlock(
          new AskingPointOnPlane(
              asking_, seen.p_rig, seen.u, plane.plane.centre, plane.plane.normal, kPointSigma_m),
          loss,
          blocks_[seen.segment].data(),
          blocks_[seen.segment + 1].data(),
          plane.change.data());
    }
  }

  std::vector<FreePlane>& planes_;
  std::vector<PoseBlock> blocks_;
  Asking asking_;
  ceres::Problem problem_;
};

}  // namespace

RefineReport refine_path(const std::vector<Returns>& sweeps,
                         const std::optional<PathPrior>& prior,
                         const RefineOptions& options,
                         std::vector<TimedPose>& path,
                         const std::function<void(std::size_t, std::size_t)>& progress) {
  RefineReport report;
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<FreePlane> planes = find_planes(sweeps, path, options.points_per_sweep);
    if (planes.empty()) {
      throw Error(
          ErrorKind::kNumeric,
          fmt::format("joint refinement of the path: found no plane that {} sweeps see", kFewestSweeps));
    }
    report.planes = planes.size();
    report.residuals = 0;
    for (const FreePlane& plane : planes) report.residuals += plane.observations.size();
    JointProblem problem(planes, path, prior);
    problem.solve(path);
    if (round + 1 == options.rounds) problem.measure(report);
    if (progress) progress(static_cast<std::size_t>(round) + 1, static_cast<std::size_t>(options.rounds));
  }
  return report;
}

}  // namespace simuli::calibration
