// Tests gradients of actors' particles and poses against differences.
#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <span>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/render/actor_scenes.hpp"
#include "tests/render/gradient/gradient_problem.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using test::SceneCase;

/// L = sum of weight x output as a function of parameters and actor poses.
class ActorProblem {
 public:
  ActorProblem(const test::Shot& shot, const GaussianSet& set)
      : device_(test::device()),
        renderer_(device_, test::smooth_options(Precision::kDouble)),
        rays_(shot.on(device_, test::smooth_options(Precision::kDouble))),
        view_(shot.view),
        particles_(device_, set, Precision::kDouble),
        grads_(device_, "parameter gradients", Precision::kDouble),
        base_(particles_.params.download_double()) {
    test::Random random(11);
    weights_.resize(std::size_t{5} * rays_.grid().frame.slots);
    for (double& w : weights_) w = random.normal();
  }
  [[nodiscard]] View& view() { return view_; }
  [[nodiscard]] std::size_t at(int row, int particle) const {
    return static_cast<std::size_t>(row) * particles_.stride + static_cast<std::size_t>(particle);
  }
  [[nodiscard]] double loss() {
    Pass pass = renderer_.render(particles_, rays_, view_);
    const std::vector<double> out = test::outputs(pass);
    double loss = 0.0;
    for (std::size_t i = 0; i < out.size(); ++i) loss += weights_[i] * out[i];
    return loss;
  }
  /// Returns the central difference of the loss for `move(h)`, extrapolated once.
  template <class Move>
  [[nodiscard]] double quotient(const Move& move, double h) {
    const auto moved_loss = [&](double step) {
      move(step);
      const double moved = loss();
      move(0.0);
      return moved;
    };
    return test::extrapolated_quotient(moved_loss, h);
  }
  [[nodiscard]] double parameter_quotient(std::size_t parameter, double h) {
    return quotient(
        [&](double step) {
          std::vector<double> moved = base_;
          moved[parameter] += step;
          particles_.params.assign(std::span<const double>(moved));
        },
        h);
  }
  [[nodiscard]] std::vector<double> gradient() {
    Pass pass = renderer_.render(particles_, rays_, view_);
    pass.set_output_gradients(test::by_ray(pass.rays(), weights_));
    pass.backward(particles_, grads_);
    pass_ = pass;
    return grads_.download_double();
  }
  /// Returns the pose gradients of the last gradient().
  [[nodiscard]] std::vector<ActorPoseGradient> pose_gradients() { return pass_->pose_gradients(particles_); }

 private:
  Device device_;
  Renderer renderer_;
  std::optional<Pass> pass_;
  SensorRays rays_;
  View view_;
  ParticleBuffers particles_;
  RealBuffer grads_;
  std::vector<double> base_, weights_;
};

/// Large soft particles, away from clamps, a third of them on actors.
ActorProblem smooth_problem(const SceneCase& scene, double step_m, double turn_rad) {
  const bool camera = scene.kind == SetKind::kCamera;
  test::Shot shot = camera ? test::shot_of(scene, 24, 20) : test::shot_of(scene, 60, 12);
  shot.view.actors = test::cars(step_m, turn_rad);
  test::SetRecipe recipe{.count = 15,
                         .low = {5, -2, -1},
                         .high = {9, 2, 1},
                         .scale_min = 0.3,
                         .scale_max = 0.7,
                         .opacity_min = 0.2,
                         .opacity_max = 0.9,
                         .sh_spread = 0.1};
  GaussianSet set = test::set_for(scene, recipe, 5);
  set.sh(0).array() += 1.5F;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    set.actor.push_back(static_cast<std::uint32_t>(i % 3));
    if (i % 3 != 0) set.mean().row(i) = (set.mean().row(i) - Eigen::RowVector3f(7, 0, 0)) * 0.5F;
  }
  return {shot, set};
}

struct WorstError {
  double parameters = 0.0;  // relative to the largest quotient of its row's kind
  double poses = 0.0;
};
WorstError worst_errors(ActorProblem& problem, const SceneCase& scene) {
  constexpr double kStep = 1e-4;
  WorstError out;
  const std::vector<double> gradient = problem.gradient();
  const std::vector<ActorPoseGradient> poses = problem.pose_gradients();
  for (int first : {kMeanRow + 0, kLogScaleRow + 0, kRotationRow + 0, kOpacityRow + 0, kShRow + 0}) {
    const int last = first == kMeanRow       ? kLogScaleRow
                     : first == kLogScaleRow ? kRotationRow
                     : first == kRotationRow ? kOpacityRow
                     : first == kOpacityRow  ? kShRow
                                             : param_rows(scene.sh_degree);
    double scale = 0.0, error = 0.0;
    for (int row = first; row < last; ++row) {
      for (const int particle : {0, 1, 5, 8}) {
        const std::size_t parameter = problem.at(row, particle);
        const double numeric = problem.parameter_quotient(parameter, kStep);
        scale = std::max(scale, std::abs(numeric));
        error = std::max(error, std::abs(gradient[parameter] - numeric));
      }
    }
    EXPECT_GT(scale, 0.0);
    out.parameters = std::max(out.parameters, error / scale);
  }
  for (std::size_t a = 0; a < 2; ++a) {
    const ActorView held = problem.view().actors[a];
    const Vector3d* analytic[] = {
        &poses[a].shift_start, &poses[a].revolution_start, &poses[a].shift_end, &poses[a].turn_end};
    for (std::size_t part = 0; part < 4; ++part) {
      double scale = 0.0, error = 0.0;
      for (Eigen::Index k = 0; k < 3; ++k) {
        const double numeric = problem.quotient(
            [&](double h) {
              ActorView& view = problem.view().actors[a];
              view = held;
              Pose& pose = part < 2 ? view.scene_from_actor_start : view.scene_from_actor_end;
              if (part % 2 == 0) {
                pose.translation(k) += h;
              } else {
                pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(h, Vector3d::Unit(k))) * pose.rotation;
              }
            },
            kStep);
        scale = std::max(scale, std::abs(numeric));
        error = std::max(error, std::abs((*analytic[part])(k)-numeric));
      }
      EXPECT_GT(scale, 0.0);
      out.poses = std::max(out.poses, error / scale);
    }
  }
  return out;
}

TEST(ActorGradients, UnderAGlobalShutterMatchDifferences) {
  SIMULI_NEEDS_DOUBLE(test::device());
  constexpr SceneCase kCase{"camera_sh1", SetKind::kCamera, false, false, 1};
  ActorProblem problem = smooth_problem(kCase, 0.0, 0.0);
  // Start and end are the same time here: each pose has half of the gradient, and a common motion the
  // complete gradient.
  const WorstError error = worst_errors(problem, kCase);
  EXPECT_LT(error.parameters, 1e-6);
}

TEST(ActorGradients, OfWhatDrivesStraightMatchDifferences) {
  SIMULI_NEEDS_DOUBLE(test::device());
  ActorProblem problem = smooth_problem(test::kLidarMoving, 2.0, 0.0);
  const WorstError error = worst_errors(problem, test::kLidarMoving);
  EXPECT_LT(error.parameters, 1e-6);
  // A particle's rays use the time of its centre: the error is their spread over the frame.
  EXPECT_LT(error.poses, 0.1);
}

TEST(ActorGradients, OfWhatTurnsAreNearDifferences) {
  SIMULI_NEEDS_DOUBLE(test::device());
  ActorProblem problem = smooth_problem(test::kLidarMoving, 2.0, 0.1);
  const WorstError error = worst_errors(problem, test::kLidarMoving);
  EXPECT_LT(error.parameters, 2e-2);
  EXPECT_LT(error.poses, 0.1);
}

TEST(ActorGradients, OfPosesAreTheSameBitsEachTime) {
  SIMULI_NEEDS_DOUBLE(test::device());
  ActorProblem problem = smooth_problem(test::kLidarMoving, 2.0, 0.1);
  (void)problem.gradient();
  const auto first = problem.pose_gradients();
  (void)problem.gradient();
  const auto again = problem.pose_gradients();
  for (std::size_t a = 0; a < first.size(); ++a) {
    EXPECT_EQ(first[a].shift_start, again[a].shift_start);
    EXPECT_EQ(first[a].turn_end, again[a].turn_end);
    EXPECT_GT(first[a].shift_start.norm(), 0.0);
  }
}

}  // namespace
}  // namespace simuli
