#include "optim/calibration/lens/lens_fit.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <fmt/format.h>
#include <vector>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "optim/calibration/lens/lens_jets.hpp"

namespace simuli::calibration {
namespace {

using lens_jets::F;

constexpr int kFocal = 4;  // parameters before the lens's: fx, fy, cx, cy

struct Sample {
  Eigen::Vector3d direction;
  Eigen::Vector2d pixel;
};

int lens_parameters(LensKind kind) {
  return std::max(0, static_cast<int>(lens_parameter_names(kind).size()) - 1);  // without max_angle_rad
}

/// Parameters in the layout of Lens::fill_constants, without domain limits.
lens_jets::Constants constants_of(LensKind kind, const std::vector<F>& lens) {
  lens_jets::Constants k{};
  constexpr double kFar = 1e9;
  switch (kind) {
    case LensKind::kPinhole:
    case LensKind::kEquirectangular:
      break;
    case LensKind::kOpencvPinhole:
      std::copy_n(lens.begin(), 12, k.distortion);
      k.radius2_max = F(kFar);
      break;
    case LensKind::kOpencvFisheye:
      std::copy_n(lens.begin(), 4, k.polynomial);
      k.angle_max = F(kPi);
      break;
    case LensKind::kFtheta:
    case LensKind::kFthetaInverse:
      std::copy_n(lens.begin(), 5, k.polynomial);
      std::copy_n(lens.begin() + 5, 3, k.linear);
      k.angle_max = F(kPi);
      k.radius_max = F(2.0 * kPi);
      break;
    case LensKind::kMei:
      std::copy_n(lens.begin(), 4, k.distortion);
      k.xi = lens[4];
      k.cos_min = F(-1.0);
      k.radius2_max = F(kFar);
      break;
    case LensKind::kDoubleSphere:
      k.xi = lens[0];
      k.alpha = lens[1];
      k.cos_min = F(-1.0);
      break;
    case LensKind::kEucm:
      k.alpha = lens[0];
      k.beta = lens[1];
      k.cos_min = F(-1.0);
      break;
  }
  return k;
}

/// Pixel of a direction as Jets in fx, fy, cx, cy and the lens's parameters.
Eigen::Matrix<F, 2, 1> pixel_jets(LensKind kind, const double* parameters, const Eigen::Vector3d& d) {
  const int count = lens_parameters(kind);
  std::vector<F> lens;
  for (int i = 0; i < count; ++i) lens.emplace_back(parameters[kFocal + i], kFocal + i);
  F u(0.0);
  F v(0.0);
  (void)lens_jets::project(kind, constants_of(kind, lens), F(d.x()), F(d.y()), F(d.z()), u, v);
  const F fx(parameters[0], 0);
  const F fy(parameters[1], 1);
  const F cx(parameters[2], 2);
  const F cy(parameters[3], 3);
  return {fx * u + cx, fy * v + cy};
}

class SamePixel : public ceres::CostFunction {
 public:
  SamePixel(LensKind kind, const Sample& sample) : kind_(kind), sample_(sample) {
    set_num_residuals(2);
    mutable_parameter_block_sizes()->push_back(kFocal + lens_parameters(kind));
  }
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Matrix<F, 2, 1> pixel = pixel_jets(kind_, parameters[0], sample_.direction);
    const int count = kFocal + lens_parameters(kind_);
    for (int i = 0; i < 2; ++i) {
      residuals[i] = pixel[i].a - sample_.pixel[i];
      if (!std::isfinite(residuals[i])) return false;
      if (jacobians == nullptr || jacobians[0] == nullptr) continue;
      for (int k = 0; k < count; ++k) jacobians[0][i * count + k] = pixel[i].v[k];
    }
    return true;
  }

 private:
  LensKind kind_;
  Sample sample_;
};

/// Rays through a pixel grid with `side` steps along the longer side, shifted by `phase` of a step.
std::vector<Sample> sample_rays(const Camera& source, int side, double phase, double widest_rad) {
  const double step = static_cast<double>(std::max(source.width, source.height)) / side;
  std::vector<Sample> samples;
  for (double y = phase * step; y <= source.height; y += step) {
    for (double x = phase * step; x <= source.width; x += step) {
      const Eigen::Vector3d direction = source.unproject({x, y});
      if (direction.isZero(0.0)) continue;
      const double angle = std::atan2(direction.head<2>().norm(), direction.z());
      constexpr double kOnAxis_rad = 1e-6;  // there the radius has no derivative
      if (angle >= kOnAxis_rad && angle <= widest_rad) samples.push_back({direction, {x, y}});
    }
  }
  return samples;
}

/// The widest usable ray of a model of this kind.
double widest_angle(LensKind kind) {
  constexpr double kPerspective_rad = 1.45;  // 83 degrees: beyond, the picture plane diverges
  const bool is_plane = kind == LensKind::kPinhole || kind == LensKind::kOpencvPinhole;
  return is_plane ? kPerspective_rad : kPi - 1e-3;
}

std::vector<double> first_guess(const Camera& source, LensKind kind) {
  const double focal_x = source.fx * source.lens.centre_slope();
  const double focal_y = source.fy * source.lens.centre_slope();
  std::vector<double> lens(static_cast<std::size_t>(lens_parameters(kind)), 0.0);
  double scale = 1.0;  // focal lengths per rad at the axis
  switch (kind) {
    case LensKind::kFtheta:
    case LensKind::kFthetaInverse:
      lens[0] = 1.0;
      lens[5] = 1.0;
      break;
    case LensKind::kMei:
      lens[4] = 1.0;
      scale = 0.5;
      break;
    case LensKind::kDoubleSphere:
      lens[1] = 0.5;
      break;
    case LensKind::kEucm:
      lens = {0.5, 1.0};
      break;
    default:
      break;
  }
  std::vector<double> out{focal_x / scale, focal_y / scale, source.cx, source.cy};
  out.insert(out.end(), lens.begin(), lens.end());
  return out;
}

/// Indices of fixed parameters.
std::vector<int> held(LensKind kind, bool rational) {
  switch (kind) {
    case LensKind::kOpencvPinhole:
      if (rational) return {kFocal + 8, kFocal + 9, kFocal + 10, kFocal + 11};
      return {kFocal + 5, kFocal + 6, kFocal + 7, kFocal + 8, kFocal + 9, kFocal + 10, kFocal + 11};
    case LensKind::kFtheta:
    case LensKind::kFthetaInverse:
      return {kFocal, kFocal + 5};  // fx and fy already scale the polynomial and the picture's axes
    default:
      return {};
  }
}

/// Solves from `parameters`; returns the mean squared error in px^2.
double solve(LensKind kind,
             const std::vector<Sample>& samples,
             bool rational,
             std::vector<double>& parameters) {
  ceres::Problem problem;
  double* const block = parameters.data();
  for (const Sample& sample : samples) problem.AddResidualBlock(new SamePixel(kind, sample), nullptr, block);
  const std::vector<int> constant = held(kind, rational);
  if (!constant.empty()) {
    problem.SetManifold(block, new ceres::SubsetManifold(static_cast<int>(parameters.size()), constant));
  }
  const auto bound = [&](int place, double low, double high) {
    problem.SetParameterLowerBound(block, kFocal + place, low);
    problem.SetParameterUpperBound(block, kFocal + place, high);
  };
  if (kind == LensKind::kMei) bound(4, 0.0, 10.0);
  if (kind == LensKind::kDoubleSphere) {
    bound(0, -0.99, 0.99);
    bound(1, 0.0, 1.0);
  }
  if (kind == LensKind::kEucm) {
    bound(0, 0.0, 1.0);
    bound(1, 1e-3, 100.0);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.gradient_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    throw Error(ErrorKind::kNumeric, fmt::format("fit of a {} lens: {}", to_string(kind), summary.message));
  }
  return 2.0 * summary.final_cost / static_cast<double>(samples.size());
}

Camera camera_of(const Camera& source,
                 LensKind kind,
                 const std::vector<double>& parameters,
                 double widest_rad) {
  Camera out = source;
  out.fx = parameters[0];
  out.fy = parameters[1];
  out.cx = parameters[2];
  out.cy = parameters[3];
  std::vector<double> lens(parameters.begin() + kFocal, parameters.end());
  if (!lens_parameter_names(kind).empty()) lens.push_back(widest_rad);
  out.lens = Lens(kind, lens, "camera " + source.name);
  return out;
}

}  // namespace

LensFit fit_lens(const Camera& source, LensKind kind) {
  constexpr int kSide = 48;
  constexpr double kGoodEnough_px = 0.01;
  if (kind == LensKind::kEquirectangular) {
    throw Error(ErrorKind::kUsage,
                "model: found equirectangular, which has no parameter to fit, allowed any other");
  }
  const std::vector<Sample> samples = sample_rays(source, kSide, 0.0, widest_angle(kind));
  if (samples.size() < 100) {
    throw Error(
        ErrorKind::kNumeric,
        fmt::format("fit of a {} lens to camera {}: found {} pixels with a ray that it can have, allowed "
                    "at least 100",
                    to_string(kind),
                    source.name,
                    samples.size()));
  }
  std::vector<double> parameters = first_guess(source, kind);
  const double error = solve(kind, samples, false, parameters);
  if (kind == LensKind::kOpencvPinhole && !(error <= kGoodEnough_px * kGoodEnough_px)) {
    std::vector<double> rational = parameters;
    if (solve(kind, samples, true, rational) < 0.25 * error) parameters = rational;
  }
  double widest_rad = 0.0;
  for (const Sample& s : samples) {
    widest_rad = std::max(widest_rad, std::atan2(s.direction.head<2>().norm(), s.direction.z()));
  }
  LensFit fit;
  fit.camera = camera_of(source, kind, parameters, std::min(kPi, widest_rad + 1e-9));
  fit.samples = samples.size();
  std::size_t uncovered = 0;
  const std::vector<Sample> checks = sample_rays(source, 2 * kSide + 1, 0.5, kPi);
  double square = 0.0;
  for (const Sample& check : checks) {
    Eigen::Vector2d pixel;
    if (!fit.camera.project(check.direction, pixel)) {
      ++uncovered;
      continue;
    }
    const double miss = (pixel - check.pixel).norm();
    square += miss * miss;
    ++fit.checked;
    if (!(miss > fit.largest_px)) continue;
    fit.largest_px = miss;
    fit.largest_at = check.pixel;
  }
  if (fit.checked > 0) fit.rms_px = std::sqrt(square / static_cast<double>(fit.checked));
  fit.uncovered_share =
      static_cast<double>(uncovered) / static_cast<double>(std::max<std::size_t>(1, checks.size()));
  return fit;
}

Eigen::Matrix<double, 2, Eigen::Dynamic> pixel_derivatives(const Camera& camera,
                                                           const Eigen::Vector3d& direction) {
  const LensKind kind = camera.lens.kind();
  const int count = lens_parameters(kind);
  std::vector<double> parameters{camera.fx, camera.fy, camera.cx, camera.cy};
  parameters.insert(
      parameters.end(), camera.lens.parameters().begin(), camera.lens.parameters().begin() + count);
  const Eigen::Matrix<F, 2, 1> pixel = pixel_jets(kind, parameters.data(), direction);
  Eigen::Matrix<double, 2, Eigen::Dynamic> out(2, kFocal + count);
  for (int i = 0; i < 2; ++i) out.row(i) = pixel[i].v.head(kFocal + count).transpose();
  return out;
}

}  // namespace simuli::calibration
