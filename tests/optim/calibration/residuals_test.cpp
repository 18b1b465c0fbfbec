// Tests derivatives against central differences, and the residuals' poses against host/core/base/pose.hpp.
#include "optim/calibration/path/residuals.hpp"

#include <array>
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

/// Returns the analytic derivatives by column, for poses on their manifold.
std::vector<double> stated(const ceres::CostFunction& cost, const std::vector<double*>& blocks) {
  const auto count = static_cast<std::size_t>(cost.num_residuals());
  std::vector<double> residuals(count), out;
  std::vector<std::vector<double>> parts;
  std::vector<double*> places;
  for (const int size : cost.parameter_block_sizes()) {
    parts.emplace_back(count * static_cast<std::size_t>(size));
  }
  for (auto& part : parts) places.push_back(part.data());
  EXPECT_TRUE(cost.Evaluate(blocks.data(), residuals.data(), places.data()));
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const int size = cost.parameter_block_sizes()[k];
    const bool is_pose = size == PoseBlock::kSize;
    Eigen::MatrixXd along = Eigen::MatrixXd::Identity(size, is_pose ? size - 1 : size);
    if (is_pose) {
      Eigen::Matrix<double, PoseBlock::kSize, PoseBlock::kSize - 1, Eigen::RowMajor> plus;
      EXPECT_TRUE(PoseBlock::Manifold().PlusJacobian(blocks[k], plus.data()));
      along = plus;
    }
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::MatrixXd by_freedom =
        Eigen::Map<const Rows>(parts[k].data(), static_cast<Eigen::Index>(count), size) * along;
    out.insert(out.end(), by_freedom.data(), by_freedom.data() + by_freedom.size());
  }
  return out;
}

/// Returns the same by central differences.
std::vector<double> measured(const ceres::CostFunction& cost, const std::vector<double*>& blocks) {
  constexpr double kStep = 1e-6;
  const auto count = static_cast<std::size_t>(cost.num_residuals());
  std::vector<double> out;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const auto size = static_cast<std::size_t>(cost.parameter_block_sizes()[k]);
    const bool is_pose = size == PoseBlock::kSize;
    for (std::size_t i = 0; i < (is_pose ? size - 1 : size); ++i) {
      std::array<std::vector<double>, 2> sides{std::vector<double>(count), std::vector<double>(count)};
      for (const int side : {0, 1}) {
        std::vector<double> change(size), moved(blocks[k], blocks[k] + size);
        change[i] = side == 0 ? -kStep : kStep;
        if (is_pose) {
          EXPECT_TRUE(PoseBlock::Manifold().Plus(blocks[k], change.data(), moved.data()));
        } else {
          moved[i] += change[i];
        }
        std::vector<const double*> at(blocks.begin(), blocks.end());
        at[k] = moved.data();
        EXPECT_TRUE(cost.Evaluate(at.data(), sides[static_cast<std::size_t>(side)].data(), nullptr));
      }
      for (std::size_t r = 0; r < count; ++r) out.push_back((sides[1][r] - sides[0][r]) / (2.0 * kStep));
    }
  }
  return out;
}

/// Returns the largest difference of one function's analytic and another's numeric derivatives, relative to
/// the largest entry.
double difference(const ceres::CostFunction& of,
                  const ceres::CostFunction& from,
                  const std::vector<double*>& blocks) {
  const std::vector<double> x = stated(of, blocks), y = measured(from, blocks);
  double largest = 0.0, apart = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    largest = std::max(largest, std::abs(y.at(i)));
    apart = std::max(apart, std::abs(x[i] - y.at(i)));
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
  // Rotations during sweeps: none, small, and large.
  Pose end_ = start_ * random_pose(dice_, GetParam() == 0 ? 0.0 : GetParam() * 5.0 * kDegree, 2.0);
  PoseBlock from_{start_};
  PoseBlock to_{end_};
  std::vector<double*> blocks_{from_.data(), to_.data()};
};

TEST_P(Derivatives, OfAPointOnAPlane) {
  const Eigen::Vector3d p(7.0, -3.0, 1.0), centre(1.0, 2.0, 3.0);
  const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, -2).normalized();
  for (const double u : {0.0, 0.3, 1.0}) {
    const PointOnPlane cost(p, u, centre, normal, 0.02);
    EXPECT_LT(difference(cost, cost, blocks_), kDerivative) << u;
  }
  // The check detects derivatives of another plane.
  EXPECT_GT(
      difference(
          PointOnPlane(p, 0.3, centre, normal, 0.0202), PointOnPlane(p, 0.3, centre, normal, 0.02), blocks_),
      1e-3);
}

TEST_P(Derivatives, OfAPointOnAFreePlane) {
  const PointOnFreePlane cost(
      {7.0, -3.0, 1.0}, 0.8, {1.0, 2.0, 3.0}, Eigen::Vector3d(1, 2, -2).normalized(), 0.02);
  std::array<double, 3> plane{0.1, -0.05, 0.2};
  blocks_.push_back(plane.data());
  EXPECT_LT(difference(cost, cost, blocks_), kDerivative);
}

TEST_P(Derivatives, OfAPrior) {
  const ceres::AutoDiffCostFunction<PosePrior, 6, PoseBlock::kSize> cost(
      new PosePrior{PoseBlock(start_ * random_pose(dice_, 0.2, 0.3)), 0.01, 0.05});
  EXPECT_LT(difference(cost, cost, {blocks_[0]}), kDerivative);
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
    const ceres::AutoDiffCostFunction<PointOnLine, 1, PoseBlock::kSize, 1> cost(new PointOnLine(residual));
    EXPECT_LT(difference(cost, cost, {mounting.data(), &clock}), kDerivative) << name;
    // The distance, computed as in rendering.
    double value = 0.0;
    ASSERT_TRUE(residual(mounting.data(), &clock, &value));
    EXPECT_NEAR(value, (-0.7 * 0.6 + 0.4 * 0.8) / 0.5, 1e-9) << name;
  }
}

TEST_P(Derivatives, MovedPointsAreInterpolatedAsTrajectoriesAre) {
  for (const double u : {0.0, 0.25, 0.9, 1.0, 1.2}) {
    const Eigen::Vector3d p(3.0, -40.0, 2.0);
    const Eigen::Vector3d expected = interpolate(start_, end_, u) * p;
    EXPECT_LT((MovedPoint(from_.data(), to_.data(), u, p).p_world() - expected).norm(), 1e-10) << u;
  }
}

INSTANTIATE_TEST_SUITE_P(Turns, Derivatives, testing::Values(0, 1, 8));

}  // namespace
}  // namespace simuli::calibration
