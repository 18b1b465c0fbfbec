#include "optim/calibration/camera/camera_texture.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

#include "host/core/base/linear_algebra.hpp"
#include "host/core/base/parallel.hpp"
#include "host/core/base/spread.hpp"
#include "optim/calibration/camera/camera_residual.hpp"
#include "optim/calibration/camera/placed_view.hpp"
#include "optim/calibration/path/plane_map.hpp"

namespace simuli::calibration {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNear_s = 0.25;         // between a return and a picture
constexpr double kOnPlane_m = 0.06;  // distance to the voxel's plane of a return on it
constexpr double kSamePlane_m = 0.1;  // distance of neighbours that continue the surface
constexpr double kOtherSurface_m = 0.2;  // distance of neighbours that indicate an occlusion edge
constexpr double kLeastCosine = 0.05;  // smallest cosine between the line of sight and the normal
constexpr std::size_t kFewestOfPiece = 12;
constexpr std::size_t kFewestPieces = 50;
constexpr double kLeastAgreement = 0.5;  // share of a piece's luminance variance explained by intensity
constexpr double kLeastContrast = 0.01;  // standard deviation of luminance on a piece
constexpr double kNoise = 0.004;         // of luminance
constexpr double kLoss = 2.0;            // standard deviations
constexpr std::array<double, 4> kBlurs_px{1.2, 0.7, 0.7, 0.7};

/// Returns on one flat piece in one picture.
struct Piece {
  std::size_t view = 0;
  std::vector<std::uint32_t> points;
};

/// Evidence of one piece for the mounting.
struct Verdict {
  MountingMatrix information = MountingMatrix::Zero();
  MountingStep slope = MountingStep::Zero();
  double agreement = 0.0;  // share of the luminance variance explained by intensity
  bool counts = false;
};

class TextureProblem {
 public:
  TextureProblem(const std::vector<CameraView>& views,
                 const Camera& camera,
                 const Trajectory& path,
                 const std::vector<SurfacePoint>& points,
                 double spacing_rad)
      : views_(views),
        camera_(camera),
        jet_camera_(camera),
        path_(path),
        points_(points),
        cell_px_(std::max(2.0, spacing_rad * camera.focal_px())) {}

  void blur(double blur_px) {
    blur_px_ = blur_px;
    pictures_.clear();
    for (const CameraView& view : views_) {
      pictures_.push_back(std::make_unique<SmoothPicture>(view.picture, blur_px));
    }
  }

  /// Visible pieces under a mounting on which intensity and luminance agree.
  [[nodiscard]] std::vector<Piece> find_pieces(const Mounting& mounting) const {
    std::vector<std::vector<Piece>> of_view(views_.size());
    parallel_each(
        views_.size(), [&](std::size_t v) { of_view[v] = pieces_of(v, mounting); }, 1);
    std::vector<Piece> out;
    for (std::vector<Piece>& pieces : of_view) {
      std::move(pieces.begin(), pieces.end(), std::back_inserter(out));
    }
    const std::vector<Verdict> verdicts = ask(out, mounting);
    std::vector<Piece> agreed;
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (verdicts[i].counts && verdicts[i].agreement >= kLeastAgreement) agreed.push_back(std::move(out[i]));
    }
    return agreed;
  }

  [[nodiscard]] std::vector<Verdict> ask(const std::vector<Piece>& pieces, const Mounting& mounting) const {
    std::vector<PlacedView> placed;
    for (const CameraView& view : views_) placed.emplace_back(view, path_, mounting);
    std::vector<Verdict> out(pieces.size());
    parallel_each(
        pieces.size(), [&](std::size_t i) { out[i] = ask(pieces[i], placed[pieces[i].view]); }, 16);
    return out;
  }

 private:
  /// Regresses the piece's luminance on its intensity: the residual, and its derivative by the mounting.
  [[nodiscard]] Verdict ask(const Piece& piece, const PlacedView& placed) const {
    const auto count = static_cast<Eigen::Index>(piece.points.size());
    Eigen::MatrixXd plain(count, 3);
    Eigen::MatrixXd slope(count, 7);
    Eigen::VectorXd luminance(count);
    Eigen::VectorXd intensity(count);
    const SurfacePoint& origin = points_[piece.points.front()];
    const Vector3d first = origin.normal.unitOrthogonal();
    const Vector3d second = origin.normal.cross(first);
    for (Eigen::Index k = 0; k < count; ++k) {
      const SurfacePoint& point = points_[piece.points[static_cast<std::size_t>(k)]];
      const CameraPoint seen = placed.see(camera_, point.p_world);
      Vector2d pixel;
      Vector2d gradient;
      Eigen::Matrix<double, 2, 3> by_place;
      if (!pixel_of(jet_camera_, seen.position, pixel, by_place)) return {};
      luminance[k] = pictures_[piece.view]->at(pixel, gradient);
      intensity[k] = static_cast<double>(point.intensity);
      slope.row(k) = gradient.transpose() * by_place * seen.slope;
      const Vector3d along = point.p_world - origin.p_world;
      plain.row(k) << 1.0, first.dot(along), second.dot(along);
    }
    // Illumination varies over a piece, and intensity with distance and incidence: linear trends carry no
    // information.
    const double squares = static_cast<double>(count);
    const Eigen::Matrix3d normal = plain.transpose() * plain + 1e-6 * squares * Eigen::Matrix3d::Identity();
    const Eigen::Matrix<double, 3, Eigen::Dynamic> solve = normal.inverse() * plain.transpose();
    luminance -= plain * (solve * luminance);
    intensity -= plain * (solve * intensity);
    slope -= plain * (solve * slope);
    const double square = intensity.squaredNorm();
    const double gain = square > 0.0 ? intensity.dot(luminance) / square : 0.0;
    const double spread = luminance.squaredNorm();
    if (!(gain > 0.0 && spread > squares * kLeastContrast * kLeastContrast)) return {};
    const Eigen::VectorXd left = luminance - gain * intensity;
    slope -= intensity * (intensity.transpose() * slope) / square;
    Verdict out;
    out.counts = true;
    out.agreement = 1.0 - left.squaredNorm() / spread;
    const double variance = left.squaredNorm() / (squares - 4.0) + kNoise * kNoise;
    for (Eigen::Index k = 0; k < count; ++k) {
      const MountingStep j = slope.row(k).transpose();
      const double weight = 1.0 / (variance + left[k] * left[k] / (kLoss * kLoss));
      // Only the part explained by intensity moves with the mounting; the rest of the gradient is noise.
      out.information += weight * out.agreement * j * j.transpose();
      out.slope += weight * left[k] * j;
    }
    return out;
  }

  /// Visible returns of view v with flat surroundings, grouped by plane.
  [[nodiscard]] std::vector<Piece> pieces_of(std::size_t v, const Mounting& mounting) const {
    const CameraView& view = views_[v];
    const PlacedView placed(view, path_, mounting);
    const int columns = static_cast<int>(camera_.width / cell_px_) + 1;
    const int rows = static_cast<int>(camera_.height / cell_px_) + 1;
    const auto cell_of = [&](const Vector2d& pixel) {
      return std::pair{static_cast<int>(pixel.x() / cell_px_), static_cast<int>(pixel.y() / cell_px_)};
    };
    const auto place = [&](double time_s) {
      const auto found =
          std::lower_bound(points_.begin(), points_.end(), time_s, [](const SurfacePoint& p, double t) {
            return p.time_s < t;
          });
      return static_cast<std::uint32_t>(found - points_.begin());
    };
    const std::uint32_t first = place(view.exposure_start_s + mounting.time_offset_s - kNear_s);
    const std::uint32_t last = place(view.exposure_end_s + mounting.time_offset_s + kNear_s);
    struct Candidate {
      std::uint32_t point;
      Vector2d pixel;
    };
    std::vector<Candidate> candidates;
    std::vector<std::vector<std::uint32_t>> cells(static_cast<std::size_t>(columns) *
                                                  static_cast<std::size_t>(rows));
    const auto cell = [&](int x, int y) -> std::vector<std::uint32_t>& {
      return cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                   static_cast<std::size_t>(x)];
    };
    const double margin_px = 3.0 + 2.0 * blur_px_;
    for (std::uint32_t i = first; i < last; ++i) {
      Vector2d pixel;
      if (!camera_.project(placed.see(camera_, points_[i].p_world).position, pixel)) continue;
      if (!(pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() < camera_.width &&
            pixel.y() < camera_.height)) {
        continue;
      }
      const auto [x, y] = cell_of(pixel);
      cell(x, y).push_back(i);
      if (points_[i].plane >= 0 && pixel.x() >= margin_px && pixel.y() >= margin_px &&
          pixel.x() <= camera_.width - margin_px && pixel.y() <= camera_.height - margin_px) {
        candidates.push_back({i, pixel});
      }
    }
    const auto carries_on = [&](const Candidate& candidate) {
      const SurfacePoint& point = points_[candidate.point];
      if (std::abs(point.normal.dot((point.p_world - placed.centre()).normalized())) < kLeastCosine)
        return false;
      const auto [cx, cy] = cell_of(candidate.pixel);
      if (cx < 1 || cy < 1 || cx + 1 >= columns || cy + 1 >= rows) return false;
      for (int y = cy - 1; y <= cy + 1; ++y) {
        for (int x = cx - 1; x <= cx + 1; ++x) {
          bool same = false;
          for (const std::uint32_t other : cell(x, y)) {
            const double off = std::abs(point.normal.dot(points_[other].p_world - point.p_world));
            if (off > kOtherSurface_m) return false;
            same = same || off < kSamePlane_m;
          }
          if (!same) return false;
        }
      }
      return true;
    };
    std::vector<std::pair<int, std::uint32_t>> kept;  // plane, point
    for (const Candidate& candidate : candidates) {
      if (carries_on(candidate) && pictures_[v]->is_open(candidate.pixel))
        kept.emplace_back(points_[candidate.point].plane, candidate.point);
    }
    std::sort(kept.begin(), kept.end());
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < kept.size();) {
      Piece piece{v, {}};
      std::size_t end = i;
      for (; end < kept.size() && kept[end].first == kept[i].first; ++end)
        piece.points.push_back(kept[end].second);
      if (piece.points.size() >= kFewestOfPiece) pieces.push_back(std::move(piece));
      i = end;
    }
    return pieces;
  }

  const std::vector<CameraView>& views_;
  const Camera& camera_;
  JetCamera jet_camera_;
  const Trajectory& path_;
  const std::vector<SurfacePoint>& points_;
  double cell_px_;
  double blur_px_ = 0.0;
  std::vector<std::unique_ptr<SmoothPicture>> pictures_;
};

double correlation(const Verdict& verdict) {
  return verdict.counts ? std::sqrt(std::max(0.0, verdict.agreement)) : 0.0;
}

double median_correlation(const std::vector<Verdict>& verdicts) {
  std::vector<double> values;
  for (const Verdict& verdict : verdicts) values.push_back(correlation(verdict));
  return upper_median(std::move(values));
}

/// Covariance of the sum of the pieces' gradients: pictures up to kReach apart share pieces, so their errors
/// are correlated (Newey and West's estimate, never negative).
MountingMatrix scatter(const std::vector<Piece>& pieces,
                       const std::vector<Verdict>& verdicts,
                       std::size_t views) {
  constexpr std::size_t kReach = 3;
  std::vector<MountingStep> of_view(views, MountingStep::Zero());
  for (std::size_t i = 0; i < pieces.size(); ++i) of_view[pieces[i].view] += verdicts[i].slope;
  MountingMatrix sum = MountingMatrix::Zero();
  for (std::size_t a = 0; a < views; ++a) {
    for (std::size_t b = a < kReach ? 0 : a - kReach; b < std::min(views, a + kReach + 1); ++b) {
      const auto apart = static_cast<double>(a > b ? a - b : b - a);
      sum += (1.0 - apart / (kReach + 1.0)) * of_view[a] * of_view[b].transpose();
    }
  }
  const auto count = static_cast<double>(views);
  // Seven degrees of freedom are used. The factor is empirical: pieces of one street are correlated beyond
  // kReach. On three streets errors were up to 3, 8 and 12 times those predicted by the pictures' scatter.
  constexpr double kAlike = 4.0;
  return kAlike * kAlike * count / std::max(1.0, count - 7.0) * sum;
}

}  // namespace

Mounting moved(const Mounting& mounting, const MountingStep& step) {
  const Vector3d turn = step.segment<3>(3);
  const double angle = turn.norm();
  const Eigen::Quaterniond rotation = angle > 0.0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle))
                                                  : Eigen::Quaterniond::Identity();
  return {mounting.rig_from_camera * Pose{rotation, step.head<3>()}, mounting.time_offset_s + step[6]};
}

MountingStep step_between(const Mounting& from, const Mounting& to) {
  const Pose change = from.rig_from_camera.inverse() * to.rig_from_camera;
  MountingStep step;
  step << change.translation, rotation_vector(change.rotation), to.time_offset_s - from.time_offset_s;
  return step;
}

Pose pose_near(const Trajectory& path, double time_s) {
  constexpr double kMargin_s = 0.9 * Trajectory::kExtrapolation_s;
  return path.at(std::clamp(time_s, path.start_s() - kMargin_s, path.end_s() + kMargin_s));
}

CameraPoint camera_point(const Trajectory& world_from_rig,
                         const Mounting& mounting,
                         double recorded_s,
                         const Vector3d& p_world) {
  const CameraView view{{}, recorded_s, recorded_s};
  return PlacedView(view, world_from_rig, mounting).middle_.see(p_world);
}

std::vector<SurfacePoint> surface_points(const std::vector<Returns>& sweeps,
                                         const Trajectory& world_from_rig) {
  std::vector<SurfacePoint> points;
  PlaneMap map;
  for (const Returns& sweep : sweeps) {
    for (std::size_t i = 0; i < sweep.size(); ++i) {
      SurfacePoint point;
      point.p_world = world_from_rig.at(sweep.time_s[i]) * sweep.p_rig[i];
      point.intensity = sweep.intensity[i];
      point.time_s = sweep.time_s[i];
      map.add(point.p_world);
      points.push_back(point);
    }
  }
  map.update();
  for (SurfacePoint& point : points) {
    const int number = map.find(point.p_world);
    if (number < 0) continue;
    const Plane& plane = map.plane(number);
    if (!(std::abs(plane.normal.dot(point.p_world - plane.centre)) <= kOnPlane_m)) continue;
    point.plane = number;
    point.normal = plane.normal;
  }
  std::stable_sort(points.begin(), points.end(), [](const SurfacePoint& a, const SurfacePoint& b) {
    return a.time_s < b.time_s;
  });
  return points;
}

TextureFit fit_texture(const std::vector<CameraView>& views,
                       const Camera& camera,
                       const Trajectory& world_from_rig,
                       const std::vector<SurfacePoint>& points,
                       double spacing_rad,
                       const Mounting& start,
                       const MountingMatrix& covariance,
                       bool with_time,
                       const std::function<void(std::size_t, std::size_t)>& progress) {
  constexpr int kSteps = 8;  // iterations per blur
  constexpr double kSettled = 0.05;  // of a standard deviation
  constexpr double kFarthest = 5.0;  // standard deviations, over all unknowns
  const int unknowns = with_time ? 7 : 6;
  const auto inverse = [unknowns](const MountingMatrix& of) {
    MountingMatrix out = MountingMatrix::Zero();
    out.topLeftCorner(unknowns, unknowns) =
        pseudo_inverse(Eigen::MatrixXd(of.topLeftCorner(unknowns, unknowns)));
    return out;
  };
  const MountingMatrix believed = inverse(covariance);
  TextureFit fit{start, covariance, 0, 0, 0.0, 0.0};
  TextureProblem problem(views, camera, world_from_rig, points, spacing_rad);
  for (std::size_t stage = 0; stage < kBlurs_px.size(); ++stage) {
    problem.blur(kBlurs_px[stage]);
    const std::vector<Piece> pieces = problem.find_pieces(fit.mounting);
    if (pieces.size() < kFewestPieces) return {start, covariance, 0, 0, 0.0, 0.0};
    std::vector<Verdict> verdicts;
    MountingMatrix information;
    for (int k = 0; k <= kSteps; ++k) {
      verdicts = problem.ask(pieces, fit.mounting);
      information = believed;
      MountingStep slope = believed * step_between(start, fit.mounting);
      for (const Verdict& verdict : verdicts) {
        information += verdict.information;
        slope += verdict.slope;
      }
      if (k == kSteps) break;
      const MountingStep step = -inverse(information) * slope;
      fit.mounting = moved(fit.mounting, step);
      if (step.dot(information * step) < kSettled * kSettled) break;
    }
    if (progress) progress(stage + 1, kBlurs_px.size());
    if (stage + 1 < kBlurs_px.size()) continue;
    fit.pieces = pieces.size();
    for (const Piece& piece : pieces) fit.points += piece.points.size();
    fit.after = median_correlation(verdicts);
    fit.before = median_correlation(problem.ask(pieces, start));
    // Few pieces may agree by chance far from the start: results beyond the covariance of `start` are rejected.
    const MountingStep off = step_between(start, fit.mounting);
    if (!(off.dot(believed * off) <= kFarthest * kFarthest && fit.after > fit.before)) {
      return {start, covariance, 0, 0, 0.0, 0.0};
    }
    const MountingMatrix middle = scatter(pieces, verdicts, views.size()) + believed;
    const MountingMatrix alone = inverse(information);
    fit.covariance = alone * middle * alone.transpose();
  }
  return fit;
}

std::optional<std::array<double, 2>> texture_of(const std::vector<CameraView>& views,
                                                const Camera& camera,
                                                const Trajectory& world_from_rig,
                                                const std::vector<SurfacePoint>& points,
                                                double spacing_rad,
                                                const std::array<Mounting, 2>& mountings) {
  TextureProblem problem(views, camera, world_from_rig, points, spacing_rad);
  problem.blur(kBlurs_px.back());
  std::vector<Piece> pieces = problem.find_pieces(mountings[0]);
  for (Piece& piece : problem.find_pieces(mountings[1])) pieces.push_back(std::move(piece));
  if (pieces.size() < kFewestPieces) return std::nullopt;
  std::array<double, 2> out{};
  for (std::size_t i = 0; i < 2; ++i) {
    for (const Verdict& verdict : problem.ask(pieces, mountings[i])) {
      out[i] += correlation(verdict) / static_cast<double>(pieces.size());
    }
  }
  return out;
}

}  // namespace simuli::calibration
