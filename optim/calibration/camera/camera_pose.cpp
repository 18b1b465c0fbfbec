#include "optim/calibration/camera/camera_pose.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/spread.hpp"
#include "optim/calibration/camera/mounting_problem.hpp"

namespace simuli::calibration {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kTextureRounds = 4;  // for progress
/// Correlation factor: the same edges appear in every sweep and picture, between the same rows. On the street,
/// edges alone have an error of 28 mm where independent ones would give 2.8.
constexpr double kEdgesAlike = 10.0;
/// Largest accepted growth of the edges' distance by texture: with known truth correct texture increased it by
/// less, and texture that was wrong by 3 cm and 0.4 degrees by 14 % and more.
constexpr double kMostGrowth = 1.1;
// Largest clock error: 2 cm at 20 m/s.
constexpr double kWorstTime_s = 1e-3;

/// Search for one camera's mounting: by depth edges, then by texture, then without its clock if that is
/// undetermined.
class MountingSearch {
 public:
  using Progress = std::function<void(std::size_t, std::size_t)>;

  MountingSearch(const std::vector<CameraView>& views,
                 const LogCamera& camera,
                 const Trajectory& world_from_rig,
                 const LidarScene& scene,
                 const CameraPoseOptions& options,
                 const Progress& progress)
      : views_(views),
        camera_(camera),
        world_from_rig_(world_from_rig),
        scene_(scene),
        options_(options),
        progress_(progress),
        matcher_(views, camera, world_from_rig, scene.edges, options),
        widest_px_(options.widest_search * camera.model.focal_px()),
        narrowest_px_(std::min(3.0, widest_px_)) {}

  CameraPoseReport run() {
    lay_on_edges(widest_px_);
    TextureFit texture = fit_by_texture();
    report_.time_sigma_s = std::sqrt(texture.covariance(6, 6));
    report_.time_known = with_time_ && report_.time_sigma_s <= kWorstTime_s;
    if (with_time_ && !report_.time_known) {
      leave_clock();
      lay_on_edges(2.0 * narrowest_px_);
      texture = fit_by_texture();
    }
    take(texture);
    refuse("place along", edge_deviation_.head<3>(), kWorstTranslation_m, 1.0, "m");
    refuse("turn about", edge_deviation_.segment<3>(3), kWorstRotation_rad, 1.0 / kDegree, "deg");
    print_change();
    if (progress_ && with_time_) progress_(steps(), steps());
    return report_;
  }

 private:
  /// For progress; one more pass without the clock if it is undetermined.
  [[nodiscard]] std::size_t steps() const {
    return (options_.with_clock ? 2 : 1) * (static_cast<std::size_t>(options_.rounds) + kTextureRounds);
  }
  void tell(std::size_t done) const {
    if (progress_) progress_(steps_before_ + done, steps());
  }

  /// Alternates edge search and solving, with a reach decreasing from `first_px`.
  void lay_on_edges(double first_px) {
    for (int round = 0; round < options_.rounds; ++round) {
      const double share = std::min(1.0, 1.5 * round / std::max(1, options_.rounds - 1));
      const double reach_px = first_px * std::pow(narrowest_px_ / first_px, share);
      matches_ = matcher_.find(state_, reach_px);
      MountingProblem(matches_, given_, std::max(1.5, reach_px / 4.0), with_time_, state_).solve();
      tell(static_cast<std::size_t>(round) + 1);
    }
  }

  /// Residuals in sigmas; their scatter scales the covariance.
  [[nodiscard]] double scatter() const {
    std::vector<double> errors;
    for (const Match& m : matches_) {
      if (m.found) errors.push_back(distance_px(m.line, state_) / m.line.sigma_px);
    }
    return 1.4826 * upper_median(std::move(errors));
  }

  /// Covariance of the edge solution in the camera's axes; edge_deviation_: for independent edges.
  MountingMatrix covariance_of_edges() {
    const Eigen::MatrixXd by_edges =
        MountingProblem(matches_, given_, 1.5, with_time_, state_).covariance(with_time_);
    // Ceres rotates quaternions by half-angles about the axes of the rig.
    const Eigen::Matrix3d camera_from_rig =
        state_.rig_from_camera.pose().rotation.toRotationMatrix().transpose();
    MountingMatrix axes = MountingMatrix::Zero();
    axes.block<3, 3>(0, 3) = camera_from_rig;
    axes.block<3, 3>(3, 0) = 2.0 * camera_from_rig;
    axes(6, 6) = 1.0;
    MountingMatrix covariance = MountingMatrix::Zero();
    covariance.topLeftCorner(by_edges.rows(), by_edges.cols()) =
        scale_ * scale_ * kEdgesAlike * kEdgesAlike * by_edges;
    covariance = axes * covariance * axes.transpose();
    edge_deviation_ = covariance.diagonal().cwiseSqrt() / kEdgesAlike;
    return covariance;
  }

  /// Starts at the edge solution, with the covariance of independent edges as a prior.
  TextureFit fit_by_texture() {
    scale_ = scatter();
    const MountingMatrix covariance = covariance_of_edges();
    const auto rounds = static_cast<std::size_t>(options_.rounds);
    const Mounting by_edges{state_.rig_from_camera.pose(), state_.time_offset_s};
    TextureFit fit = fit_texture(
        views_,
        camera_.model,
        world_from_rig_,
        scene_.surfaces,
        scene_.spacing_rad,
        by_edges,
        covariance,
        with_time_,
        [&](std::size_t done, std::size_t total) { tell(rounds + done * kTextureRounds / total); });
    texture_note_ = "the pictures show nothing of the LiDAR's intensity";
    const double edges_px = apart_px(state_);
    const double texture_px = apart_px({PoseBlock(fit.mounting.rig_from_camera), fit.mounting.time_offset_s});
    if (texture_px > kMostGrowth * edges_px) {
      texture_note_ = fmt::format(
          "it would put depth edges {:.2f} px from the pictures', which lie {:.2f} px apart without it",
          texture_px,
          edges_px);
      fit = {by_edges, covariance, 0, 0, 0.0, 0.0};
    }
    return fit;
  }

  /// Median distance of matched edges.
  [[nodiscard]] double apart_px(const MountingState& state) const {
    std::vector<double> distances;
    for (const Match& m : matches_) {
      if (m.found) distances.push_back(distance_px(m.line, state));
    }
    return upper_median(std::move(distances));
  }

  void leave_clock() {
    report_.notes.push_back(
        fmt::format("clock of camera {}: not determined ({:.1f} ms), left as it is: at constant speed a late "
                    "picture is a camera mounted further ahead",
                    camera_.model.name,
                    1e3 * report_.time_sigma_s));
    with_time_ = false;
    steps_before_ = steps() / 2;
    state_.time_offset_s = 0.0;
  }

  void take(const TextureFit& texture) {
    if (texture.pieces == 0) {
      report_.notes.push_back(fmt::format(
          "texture: {}; mounting of camera {} from depth edges alone", texture_note_, camera_.model.name));
    }
    report_.pieces = texture.pieces;
    report_.texture_points = texture.points;
    report_.texture_before = texture.before;
    report_.texture_after = texture.after;
    report_.rig_from_camera = texture.mounting.rig_from_camera;
    report_.time_offset_s = texture.mounting.time_offset_s;
    state_ = {PoseBlock(report_.rig_from_camera), report_.time_offset_s};
    const MountingStep deviation = texture.covariance.diagonal().cwiseSqrt();
    report_.translation_sigma_m = deviation.head<3>();
    report_.rotation_sigma_rad = deviation.segment<3>(3);
  }

  /// Throws for a direction that no edge constrains.
  void refuse(const char* what, const Vector3d& sigma, double worst, double unit, const char* name) const {
    if (sigma.maxCoeff() <= worst) return;
    Eigen::Index axis = 0;
    (void)sigma.maxCoeff(&axis);
    throw Error(
        ErrorKind::kNumeric,
        fmt::format("mounting of camera {}: its {} the camera's {} is not determined: standard deviation "
                    "found {:.3g} {}, allowed {:.3g}",
                    camera_.model.name,
                    what,
                    "xyz"[axis],
                    sigma[axis] * unit,
                    name,
                    worst * unit));
  }

  void print_change() {
    const Pose change = camera_.rig_from_camera.inverse() * report_.rig_from_camera;
    report_.translation_change_m = change.translation;
    report_.rotation_change_rad = change.rotation.angularDistance(Eigen::Quaterniond::Identity());
    std::size_t outliers = 0;
    for (const Match& m : matches_) {
      report_.edges += m.in_view ? 1U : 0U;
      if (!m.found) continue;
      ++report_.matched;
      outliers += distance_px(m.line, state_) > 3.0 * scale_ * m.line.sigma_px ? 1U : 0U;
    }
    report_.outlier_share = static_cast<double>(outliers) / static_cast<double>(report_.matched);
    report_.before_px = apart_px(given_);
    report_.after_px = apart_px(state_);
  }

  const std::vector<CameraView>& views_;
  const LogCamera& camera_;
  const Trajectory& world_from_rig_;
  const LidarScene& scene_;
  const CameraPoseOptions& options_;
  const Progress& progress_;
  EdgeMatcher matcher_;
  double widest_px_, narrowest_px_;
  MountingState given_{PoseBlock(camera_.rig_from_camera), 0.0};
  MountingState state_ = given_;
  bool with_time_ = options_.with_clock;
  std::size_t steps_before_ = 0;
  std::vector<Match> matches_;
  std::string texture_note_;
  double scale_ = 0.0;
  MountingStep edge_deviation_ = MountingStep::Zero();
  CameraPoseReport report_;
};

}  // namespace

std::array<double, 2> edges_apart_px(const std::vector<CameraView>& views,
                                     const LogCamera& camera,
                                     const std::array<Mounting, 2>& mountings,
                                     const Trajectory& world_from_rig,
                                     const LidarScene& scene,
                                     const CameraPoseOptions& options) {
  const EdgeMatcher matcher(views, camera, world_from_rig, scene.edges, options);
  std::array<double, 2> out{};
  for (std::size_t i = 0; i < 2; ++i) {
    const MountingState state{PoseBlock(mountings[i].rig_from_camera), mountings[i].time_offset_s};
    double sum_px = 0.0;
    std::size_t in_view = 0;
    for (const Match& m : matcher.find(state, kFarEdge_px)) {
      if (!m.in_view) continue;
      ++in_view;
      sum_px += m.found ? std::min(std::abs(distance_px(m.line, state)), kFarEdge_px) : kFarEdge_px;
    }
    out[i] = in_view == 0 ? kFarEdge_px : sum_px / static_cast<double>(in_view);
  }
  return out;
}

CameraPoseReport find_camera_pose(const std::vector<CameraView>& views,
                                  const LogCamera& camera,
                                  const Trajectory& world_from_rig,
                                  const LidarScene& scene,
                                  const CameraPoseOptions& options,
                                  const std::function<void(std::size_t, std::size_t)>& progress) {
  return MountingSearch(views, camera, world_from_rig, scene, options, progress).run();
}

}  // namespace simuli::calibration
