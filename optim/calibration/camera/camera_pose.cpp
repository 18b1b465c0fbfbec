#include "optim/calibration/camera/camera_pose.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <utility>

#include "host/base/error.hpp"
#include "optim/calibration/camera/camera_residual.hpp"
#include "optim/calibration/path/median.hpp"
#include "optim/calibration/path/odometry.hpp"
#include "host/base/parallel.hpp"

namespace simuli::calibration {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kFewestMatches = 300;
constexpr double kPictureSigma_px = 0.4;  // of an edge found in a picture
/// The same rims stand in every sweep and every picture, between the same two rows: on the street, edges
/// alone leave 28 mm where independent ones would be good for 2.8.
constexpr double kEdgesAlike = 10.0;
constexpr double kPriorTranslation_m = 0.3;
constexpr double kPriorRotation_rad = 5.0 * kDegree;
constexpr double kPriorTime_s = 0.05;
// What a mounting is good for: 3 cm at 10 m; a clock: 2 cm at 20 m/s.
constexpr double kWorstTranslation_m = 0.03;
constexpr double kWorstRotation_rad = 0.2 * kDegree;
constexpr double kWorstTime_s = 1e-3;

struct Match {
  PointOnLine line;
  bool found = false;
  bool in_view = false;
};

struct State {
  PoseBlock rig_from_camera;
  double time_offset_s = 0.0;
};

/// Edges within `about_s` of each view: [views] of [first, last) into edges, which are by time.
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

/// Looks for one depth edge in one picture.
Match find_match(const CameraView& view,
                 const EdgeImage& edge_image,
                 const LogCamera& camera,
                 const Trajectory& path,
                 const DepthEdge& edge,
                 const Vector3d& p_world,
                 const Vector3d& across_world,
                 const State& state,
                 double reach_px,
                 double least_strength) {
  Match match;
  const Camera& model = camera.model;
  const Pose rig_from_camera = state.rig_from_camera.pose();
  double fraction = 0.5;
  double time_s = 0.0;
  Vector2d pixel;
  Pose camera_from_world;
  // A rolling shutter's rows are exposed when they are: twice is enough for 20 ms and any road.
  for (int k = 0; k < 2; ++k) {
    time_s = view.exposure_start_s + fraction * (view.exposure_end_s - view.exposure_start_s);
    camera_from_world = (pose_near(path, time_s + state.time_offset_s) * rig_from_camera).inverse();
    if (!model.project(camera_from_world * p_world, pixel)) return match;
    fraction = std::clamp(model.exposure_fraction(pixel), 0.0, 1.0);
  }
  constexpr double kMargin_px = 3.0;
  if (!(pixel.x() >= kMargin_px && pixel.y() >= kMargin_px && pixel.x() <= model.width - kMargin_px &&
        pixel.y() <= model.height - kMargin_px)) {
    return match;
  }
  Vector2d outside;
  if (!model.project(camera_from_world * (p_world + edge.half_width * across_world), outside)) return match;
  const double width_px = (outside - pixel).norm();
  if (!(width_px > 1e-6)) return match;
  match.in_view = true;
  EdgeImage::Edge seen;
  if (!edge_image.find(pixel, (outside - pixel) / width_px, reach_px, least_strength, seen)) return match;
  match.found = true;
  const std::vector<TimedPose>& knots = path.poses();
  const std::size_t segment = segment_of(knots, time_s + state.time_offset_s);
  match.line = {&model,
                p_world,
                knots[segment],
                knots[segment + 1],
                time_s,
                seen.pixel,
                seen.normal,
                std::hypot(kPictureSigma_px, width_px / std::sqrt(3.0))};
  return match;
}

double distance_px(const PointOnLine& line, const State& state) {
  double error = 0.0;
  const bool seen = line(state.rig_from_camera.rotation.data(),
                         state.rig_from_camera.translation.data(),
                         &state.time_offset_s,
                         &error);
  return seen ? std::abs(error) * line.sigma_px : INFINITY;
}

/// A problem in the mounting and the clock, around what was given.
class PoseProblem {
 public:
  PoseProblem(
      const std::vector<Match>& matches, const State& given, double loss, bool with_time, State& state)
      : state_(state) {
    double* const rotation = state.rig_from_camera.rotation.data();
    double* const translation = state.rig_from_camera.translation.data();
    problem_.AddParameterBlock(rotation, 4, new ceres::QuaternionManifold);
    problem_.AddParameterBlock(translation, 3);
    problem_.AddParameterBlock(&state.time_offset_s, 1);
    auto* const cauchy = new ceres::CauchyLoss(loss);
    for (const Match& match : matches) {
      if (!match.found) continue;
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PointOnLine, 1, 4, 3, 1>(new PointOnLine(match.line)),
          cauchy,
          rotation,
          translation,
          &state.time_offset_s);
    }
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PosePrior, 6, 4, 3>(new PosePrior{
                                  given.rig_from_camera, kPriorRotation_rad, kPriorTranslation_m}),
                              nullptr,
                              rotation,
                              translation);
    if (with_time) {
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<TimePrior, 1, 1>(new TimePrior), nullptr, &state.time_offset_s);
    } else {
      problem_.SetParameterBlockConstant(&state.time_offset_s);
    }
  }

  void solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 15;
    options.num_threads = 1;  // sums in one order
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (!summary.IsSolutionUsable()) {
      throw Error(ErrorKind::kNumeric, "mounting of the camera: " + summary.message);
    }
  }

  /// Half-angles about the rig's axes, place on the rig, clock: [7 x 7], or 6 without a clock.
  [[nodiscard]] Eigen::MatrixXd covariance(bool with_time) {
    ceres::Covariance::Options how;
    how.algorithm_type = ceres::DENSE_SVD;
    ceres::Covariance covariance(how);
    std::vector<const double*> blocks{state_.rig_from_camera.rotation.data(),
                                      state_.rig_from_camera.translation.data()};
    if (with_time) blocks.push_back(&state_.time_offset_s);
    const Eigen::Index size = with_time ? 7 : 6;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> out(size, size);
    if (!covariance.Compute(blocks, &problem_) ||
        !covariance.GetCovarianceMatrixInTangentSpace(blocks, out.data())) {
      throw Error(ErrorKind::kNumeric, "mounting of the camera: its covariance is not finite");
    }
    return out;
  }

 private:
  struct TimePrior {
    template <class T>
    bool operator()(const T* time_offset, T* out) const {
      out[0] = time_offset[0] / T(kPriorTime_s);
      return true;
    }
  };
  State& state_;
  ceres::Problem problem_;
};

}  // namespace

CameraPoseReport find_camera_pose(const std::vector<CameraView>& views,
                                  const LogCamera& camera,
                                  const Trajectory& world_from_rig,
                                  const LidarScene& scene,
                                  const CameraPoseOptions& options,
                                  const std::function<void(std::size_t, std::size_t)>& progress) {
  constexpr double kSmooth_px = 1.0;
  constexpr std::size_t kTextureRounds = 4;
  const std::vector<DepthEdge>& edges = scene.edges;
  const auto ranges = edges_of_views(views, edges, options.sweeps_about_s);
  std::vector<EdgeImage> edge_images;
  for (const CameraView& view : views) edge_images.emplace_back(view.picture, kSmooth_px);
  std::vector<Vector3d> p_world;
  std::vector<Vector3d> across_world;
  for (const DepthEdge& edge : edges) {
    const Pose world_from_rig_then = world_from_rig.at(edge.time_s);
    p_world.push_back(world_from_rig_then * edge.p_rig);
    across_world.push_back(world_from_rig_then.rotation * edge.across);
  }
  const State given{PoseBlock(camera.rig_from_camera), 0.0};
  State state = given;
  bool with_time = true;
  std::vector<Match> matches;
  const auto find_all = [&](double reach_px) {
    matches.clear();
    for (std::size_t v = 0; v < views.size(); ++v) {
      const auto [first, last] = ranges[v];
      const std::size_t before = matches.size();
      matches.resize(before + last - first);
      parallel_ranges(
          last - first,
          [&, from = first](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
              matches[before + i] = find_match(views[v],
                                               edge_images[v],
                                               camera,
                                               world_from_rig,
                                               edges[from + i],
                                               p_world[from + i],
                                               across_world[from + i],
                                               state,
                                               reach_px,
                                               options.least_strength);
            }
          },
          256);
    }
    const auto found = static_cast<std::size_t>(
        std::count_if(matches.begin(), matches.end(), [](const Match& m) { return m.found; }));
    if (found < kFewestMatches) {
      throw Error(
          ErrorKind::kNumeric,
          fmt::format("mounting of camera {}: not determined, found {} depth edges that lie on edges of "
                      "{} pictures, allowed at least {} (a blank wall has none)",
                      camera.model.name,
                      found,
                      views.size(),
                      kFewestMatches));
    }
  };

  const double widest_px = options.widest_search * camera.model.focal_px();
  const double narrowest_px = std::min(3.0, widest_px);
  const auto run = [&](double first_px) {
    for (int round = 0; round < options.rounds; ++round) {
      const double share = std::min(1.0, 1.5 * round / std::max(1, options.rounds - 1));
      const double reach_px = first_px * std::pow(narrowest_px / first_px, share);
      find_all(reach_px);
      PoseProblem(matches, given, std::max(1.5, reach_px / 4.0), with_time, state).solve();
      if (progress) {
        progress(static_cast<std::size_t>(round) + 1,
                 static_cast<std::size_t>(options.rounds) + kTextureRounds);
      }
    }
  };
  run(widest_px);

  CameraPoseReport report;
  // Residuals in sigmas: what they really scatter by scales the covariance.
  const auto scatter = [&] {
    std::vector<double> errors;
    for (const Match& m : matches) {
      if (m.found) errors.push_back(distance_px(m.line, state) / m.line.sigma_px);
    }
    return 1.4826 * upper_median(std::move(errors));
  };
  double scale = 0.0;
  MountingStep edge_deviation =
      MountingStep::Zero();  // were they independent: what no edge holds, shows in it
  /// From where depth edges put the camera, which is believed as far as they are independent.
  const auto by_texture = [&] {
    scale = scatter();
    const Eigen::MatrixXd by_edges = PoseProblem(matches, given, 1.5, with_time, state).covariance(with_time);
    // Ceres turns quaternions by half-angles about the axes of the rig.
    const Eigen::Matrix3d camera_from_rig =
        state.rig_from_camera.pose().rotation.toRotationMatrix().transpose();
    MountingMatrix axes = MountingMatrix::Zero();
    axes.block<3, 3>(0, 3) = camera_from_rig;
    axes.block<3, 3>(3, 0) = 2.0 * camera_from_rig;
    axes(6, 6) = 1.0;
    MountingMatrix covariance = MountingMatrix::Zero();
    covariance.topLeftCorner(by_edges.rows(), by_edges.cols()) =
        scale * scale * kEdgesAlike * kEdgesAlike * by_edges;
    covariance = axes * covariance * axes.transpose();
    edge_deviation = covariance.diagonal().cwiseSqrt() / kEdgesAlike;
    return fit_texture(views,
                       camera.model,
                       world_from_rig,
                       scene.surfaces,
                       scene.spacing_rad,
                       {state.rig_from_camera.pose(), state.time_offset_s},
                       covariance,
                       with_time,
                       [&](std::size_t done, std::size_t total) {
                         if (!progress) return;
                         progress(static_cast<std::size_t>(options.rounds) + done * kTextureRounds / total,
                                  static_cast<std::size_t>(options.rounds) + kTextureRounds);
                       });
  };
  TextureFit texture = by_texture();
  report.time_sigma_s = std::sqrt(texture.covariance(6, 6));
  report.time_known = report.time_sigma_s <= kWorstTime_s;
  if (!report.time_known) {
    report.notes.push_back(
        fmt::format("clock of camera {}: not determined ({:.1f} ms), left as it is: at constant speed a late "
                    "picture is a camera mounted further ahead",
                    camera.model.name,
                    1e3 * report.time_sigma_s));
    with_time = false;
    state.time_offset_s = 0.0;
    run(2.0 * narrowest_px);
    texture = by_texture();
  }
  if (texture.pieces == 0) {
    report.notes.push_back(
        fmt::format("texture: the pictures show nothing of the LiDAR's intensity; mounting of camera {} from "
                    "depth edges alone",
                    camera.model.name));
  }
  report.pieces = texture.pieces;
  report.texture_points = texture.points;
  report.texture_before = texture.before;
  report.texture_after = texture.after;
  report.rig_from_camera = texture.mounting.rig_from_camera;
  report.time_offset_s = texture.mounting.time_offset_s;
  state = {PoseBlock(report.rig_from_camera), report.time_offset_s};
  const MountingStep deviation = texture.covariance.diagonal().cwiseSqrt();
  report.translation_sigma_m = deviation.head<3>();
  report.rotation_sigma_rad = deviation.segment<3>(3);
  const auto refuse =
      [&](const char* what, const Vector3d& sigma, double worst, double unit, const char* name) {
        if (sigma.maxCoeff() <= worst) return;
        Eigen::Index axis = 0;
        (void)sigma.maxCoeff(&axis);
        throw Error(
            ErrorKind::kNumeric,
            fmt::format("mounting of camera {}: its {} the camera's {} is not determined: standard deviation "
                        "found {:.3g} {}, allowed {:.3g}",
                        camera.model.name,
                        what,
                        "xyz"[axis],
                        sigma[axis] * unit,
                        name,
                        worst * unit));
      };
  refuse("place along", edge_deviation.head<3>(), kWorstTranslation_m, 1.0, "m");
  refuse("turn about", edge_deviation.segment<3>(3), kWorstRotation_rad, 1.0 / kDegree, "deg");

  const Pose change = camera.rig_from_camera.inverse() * report.rig_from_camera;
  report.translation_change_m = change.translation;
  report.rotation_change_rad = change.rotation.angularDistance(Eigen::Quaterniond::Identity());
  std::vector<double> before;
  std::vector<double> after;
  std::size_t outliers = 0;
  for (const Match& m : matches) {
    report.edges += m.in_view ? 1U : 0U;
    if (!m.found) continue;
    before.push_back(distance_px(m.line, given));
    after.push_back(distance_px(m.line, state));
    outliers += after.back() > 3.0 * scale * m.line.sigma_px ? 1U : 0U;
  }
  report.matched = after.size();
  report.outlier_share = static_cast<double>(outliers) / static_cast<double>(after.size());
  report.before_px = upper_median(std::move(before));
  report.after_px = upper_median(std::move(after));
  return report;
}

}  // namespace simuli::calibration
