// Automatic derivatives against central differences, and the residuals' poses against host/core/base/pose.hpp.
#include "optim/calibration/path/residuals.hpp"

#include <ceres/numeric_diff_cost_function.h>
#include <gtest/gtest.h>
#include <random>

#include "host/core/base/angles.hpp"
#include "optim/calibration/camera/camera_residual.hpp"

namespace simuli::calibration {
namespace {

Pose random_pose(std::mt19937_64& dice, double turn_rad, double reach_m) {
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  const Eigen::Vector3d axis = Eigen::Vector3d(in(dice), in(dice), in(dice)).normalized();
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad * in(dice), axis)),
          reach_m * Eigen::Vector3d(in(dice), in(dice), in(dice))};
}

/// Largest difference of two Jacobians over the largest entry.
double difference(const ceres::CostFunction& a,
                  const ceres::CostFunction& b,
                  const std::vector<double*>& blocks) {
  const auto jacobian = [&](const ceres::CostFunction& cost) {
    std::vector<double> residuals(static_cast<std::size_t>(cost.num_residuals()));
    std::vector<std::vector<double>> parts;
    std::vector<double*> places;
    for (const int size : cost.parameter_block_sizes()) {
      parts.emplace_back(residuals.size() * static_cast<std::size_t>(size));
    }
    for (auto& part : parts) places.push_back(part.data());
    EXPECT_TRUE(cost.Evaluate(blocks.data(), residuals.data(), places.data()));
    std::vector<double> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
  };
  const std::vector<double> x = jacobian(a);
  const std::vector<double> y = jacobian(b);
  double largest = 0.0;
  double apart = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    largest = std::max(largest, std::abs(y[i]));
    apart = std::max(apart, std::abs(x[i] - y[i]));
  }
  EXPECT_GT(largest, 0.0);
  return apart / largest;
}

// Central differences in double are good to about 1e-8 of the largest entry.
constexpr double kDerivative = 1e-6;

class Derivatives : public testing::TestWithParam<int> {
 protected:
  std::mt19937_64 dice_{static_cast<std::uint64_t>(GetParam())};
  Pose start_ = random_pose(dice_, 3.0, 20.0);
  // Sweeps turn by nothing, by a little, and by a lot.
  Pose end_ = start_ * random_pose(dice_, GetParam() == 0 ? 0.0 : GetParam() * 5.0 * kDegree, 2.0);
  PoseBlock from_{start_};
  PoseBlock to_{end_};
  std::vector<double*> blocks_{
      from_.rotation.data(), from_.translation.data(), to_.rotation.data(), to_.translation.data()};
};

TEST_P(Derivatives, OfAPointOnAPlane) {
  const PointOnPlane residual{
      {7.0, -3.0, 1.0}, 0.3, {1.0, 2.0, 3.0}, Eigen::Vector3d(1, 2, -2).normalized(), 0.02};
  const ceres::AutoDiffCostFunction<PointOnPlane, 1, 4, 3, 4, 3> automatic(new PointOnPlane(residual));
  const ceres::NumericDiffCostFunction<PointOnPlane, ceres::CENTRAL, 1, 4, 3, 4, 3> numeric(
      new PointOnPlane(residual));
  EXPECT_LT(difference(automatic, numeric, blocks_), kDerivative);
  // A check that can fail: another plane's derivatives are not taken for these.
  PointOnPlane other = residual;
  other.sigma_m *= 1.01;
  const ceres::AutoDiffCostFunction<PointOnPlane, 1, 4, 3, 4, 3> wrong(new PointOnPlane(other));
  EXPECT_GT(difference(wrong, numeric, blocks_), 1e-3);
}

TEST_P(Derivatives, OfAPointOnAFreePlane) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, -2).normalized();
  const Eigen::Vector3d first = normal.unitOrthogonal();
  const PointOnFreePlane residual{
      {7.0, -3.0, 1.0}, 0.8, {1.0, 2.0, 3.0}, normal, first, normal.cross(first), 0.02};
  std::array<double, 3> plane{0.1, -0.05, 0.2};
  blocks_.push_back(plane.data());
  const ceres::AutoDiffCostFunction<PointOnFreePlane, 1, 4, 3, 4, 3, 3> automatic(
      new PointOnFreePlane(residual));
  const ceres::NumericDiffCostFunction<PointOnFreePlane, ceres::CENTRAL, 1, 4, 3, 4, 3, 3> numeric(
      new PointOnFreePlane(residual));
  EXPECT_LT(difference(automatic, numeric, blocks_), kDerivative);
}

TEST_P(Derivatives, OfAPrior) {
  const PosePrior residual{PoseBlock(start_ * random_pose(dice_, 0.2, 0.3)), 0.01, 0.05};
  const ceres::AutoDiffCostFunction<PosePrior, 6, 4, 3> automatic(new PosePrior(residual));
  const ceres::NumericDiffCostFunction<PosePrior, ceres::CENTRAL, 6, 4, 3> numeric(new PosePrior(residual));
  EXPECT_LT(difference(automatic, numeric, {blocks_[0], blocks_[1]}), kDerivative);
}

TEST_P(Derivatives, OfAPointOnALineInEveryLens) {
  for (const std::string& name : builtin_camera_names()) {
    const Camera camera = builtin_camera(name);
    const Eigen::Vector3d p_camera(0.6, -0.4, 5.0);
    Eigen::Vector2d pixel;
    ASSERT_TRUE(camera.project(p_camera, pixel)) << name;
    const Pose rig_from_camera = random_pose(dice_, 3.0, 1.0);
    PoseBlock mounting(rig_from_camera);
    double clock = 0.004;
    const TimedPose from{10.0, start_};
    const TimedPose to{10.1, end_};
    const double time_s = 10.03;
    const Pose world_from_rig = interpolate(start_, end_, 0.34);
    const JetCamera jet_camera(camera);
    const PointOnLine residual{&jet_camera,
                               world_from_rig * rig_from_camera * p_camera,
                               from,
                               to,
                               time_s,
                               pixel + Eigen::Vector2d(0.7, -0.4),
                               Eigen::Vector2d(0.6, 0.8),
                               0.5};
    const ceres::AutoDiffCostFunction<PointOnLine, 1, 4, 3, 1> automatic(new PointOnLine(residual));
    const ceres::NumericDiffCostFunction<PointOnLine, ceres::CENTRAL, 1, 4, 3, 1> numeric(
        new PointOnLine(residual));
    const std::vector<double*> blocks{mounting.rotation.data(), mounting.translation.data(), &clock};
    EXPECT_LT(difference(automatic, numeric, blocks), kDerivative) << name;
    // The distance itself, by the road that rendering takes.
    double value = 0.0;
    ASSERT_TRUE(residual(mounting.rotation.data(), mounting.translation.data(), &clock, &value));
    EXPECT_NEAR(value, (-0.7 * 0.6 + 0.4 * 0.8) / 0.5, 1e-9) << name;
  }
}

TEST_P(Derivatives, MovedPointsAreInterpolatedAsTrajectoriesAre) {
  for (const double u : {0.0, 0.25, 0.9, 1.0, 1.2}) {
    const Eigen::Vector3d p(3.0, -40.0, 2.0);
    double out[3];
    moved_point(blocks_[0], blocks_[1], blocks_[2], blocks_[3], u, p, out);
    const Eigen::Vector3d expected = interpolate(start_, end_, u) * p;
    EXPECT_LT((Eigen::Vector3d(out[0], out[1], out[2]) - expected).norm(), 1e-10) << u;
  }
}

INSTANTIATE_TEST_SUITE_P(Turns, Derivatives, testing::Values(0, 1, 8));

}  // namespace
}  // namespace simuli::calibration
