#include "host/core/sensors/lens.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cl/shared/sensor_constants.h"
#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/sensors/lens/lens_forward.hpp"

namespace simuli {
namespace {

static_assert(static_cast<int>(LensKind::kPinhole) == SIM_LENS_PINHOLE);
static_assert(static_cast<int>(LensKind::kOpencvPinhole) == SIM_LENS_OPENCV_PINHOLE);
static_assert(static_cast<int>(LensKind::kOpencvFisheye) == SIM_LENS_OPENCV_FISHEYE);
static_assert(static_cast<int>(LensKind::kFtheta) == SIM_LENS_FTHETA);
static_assert(static_cast<int>(LensKind::kFthetaInverse) == SIM_LENS_FTHETA_INVERSE);
static_assert(static_cast<int>(LensKind::kMei) == SIM_LENS_MEI);
static_assert(static_cast<int>(LensKind::kEquirectangular) == SIM_LENS_EQUIRECTANGULAR);
static_assert(static_cast<int>(LensKind::kDoubleSphere) == SIM_LENS_DOUBLE_SPHERE);
static_assert(static_cast<int>(LensKind::kEucm) == SIM_LENS_EUCM);

// Largest reprojection error of unproject in focal lengths: far below a thousandth of a pixel for focal lengths
// up to 1e5 px, far above the rounding of the iterations.
constexpr double kReprojection = 1e-9;
constexpr double kLargest = 1e6;  // coefficients of real lenses are below 1e3; polynomials stay finite

/// Throws unless the parameter `name`, if this kind has it, is in [low, high].
void need_between(const std::vector<std::string>& names,
                  const std::vector<double>& values,
                  std::string_view name,
                  double low,
                  double high,
                  const std::string& file) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return;
  const double value = values[static_cast<std::size_t>(found - names.begin())];
  if (!(value >= low && value <= high)) {
    throw_input_error(file, name, fmt::format("{}", value), fmt::format("{} to {}", low, high));
  }
}

void check(LensKind kind, const std::vector<double>& values, const std::string& file) {
  const auto& names = lens_parameter_names(kind);
  if (values.size() != names.size()) {
    throw_input_error(file,
                      to_string(kind),
                      fmt::format("{} parameters", values.size()),
                      fmt::format("{}: {}", names.size(), fmt::join(names, ", ")));
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(std::abs(values[i]) <= kLargest)) {
      throw_input_error(file, names[i], fmt::format("{}", values[i]), "finite, at most 1e6");
    }
  }
  need_between(names, values, "max_angle_rad", 1e-6, kPi, file);
  for (const char* const positive : {"a1", "b1", "beta"}) {
    need_between(names, values, positive, 1e-9, kLargest, file);
  }
  need_between(names, values, "alpha", 0.0, 1.0, file);
  if (kind == LensKind::kMei) need_between(names, values, "xi", 0.0, kLargest, file);
  if (kind == LensKind::kDoubleSphere) need_between(names, values, "xi", -0.999, 0.999, file);
  if (kind == LensKind::kFtheta || kind == LensKind::kFthetaInverse) {
    const double c = values[5], d = values[6], e = values[7];
    if (!(c - d * e > 1e-6)) {
      throw_input_error(file, "c, d, e", fmt::format("{}, {}, {}", c, d, e), "c - d e above 1e-6");
    }
  }
}

}  // namespace

const std::vector<std::string>& lens_names() {
  static const std::vector<std::string> names{"pinhole",
                                              "opencv_pinhole",
                                              "opencv_fisheye",
                                              "ftheta_angle_to_radius",
                                              "ftheta_radius_to_angle",
                                              "mei",
                                              "equirectangular",
                                              "double_sphere",
                                              "eucm"};
  return names;
}

const char* to_string(LensKind kind) { return lens_names().at(static_cast<std::size_t>(kind)).c_str(); }

LensKind lens_from_string(const std::string& name, const std::string& file, const std::string& field) {
  const auto& names = lens_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    throw_input_error(file, field, '"' + name + '"', fmt::format("{}", fmt::join(names, ", ")));
  }
  return static_cast<LensKind>(found - names.begin());
}

const std::vector<std::string>& lens_parameter_names(LensKind kind) {
  static const std::vector<std::vector<std::string>> names{
      {},
      {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4", "max_angle_rad"},
      {"k1", "k2", "k3", "k4", "max_angle_rad"},
      {"a1", "a2", "a3", "a4", "a5", "c", "d", "e", "max_angle_rad"},
      {"b1", "b2", "b3", "b4", "b5", "c", "d", "e", "max_angle_rad"},
      {"k1", "k2", "p1", "p2", "xi", "max_angle_rad"},
      {},
      {"xi", "alpha", "max_angle_rad"},
      {"alpha", "beta", "max_angle_rad"}};
  return names.at(static_cast<std::size_t>(kind));
}

Lens::Lens() : constants_(std::make_shared<shared::LensConstants<double>>()) {}

Lens::Lens(LensKind kind, const std::vector<double>& parameters, const std::string& file)
    : kind_(kind), parameters_(parameters), constants_(std::make_shared<shared::LensConstants<double>>()) {
  check(kind, parameters, file);
  fill_constants();
  find_domain(parameters.empty() ? kPi : parameters.back());
}

void Lens::fill_constants() {
  const auto& p = parameters_;
  auto& c = *constants_;
  switch (kind_) {
    case LensKind::kPinhole:
    case LensKind::kEquirectangular:
      break;
    case LensKind::kOpencvPinhole:
      std::copy_n(p.begin(), 12, c.distortion);
      break;
    case LensKind::kOpencvFisheye:
      std::copy_n(p.begin(), 4, c.polynomial);
      break;
    case LensKind::kFtheta:
    case LensKind::kFthetaInverse:
      std::copy_n(p.begin(), 5, c.polynomial);
      std::copy_n(p.begin() + 5, 3, c.linear);
      break;
    case LensKind::kMei:
      std::copy_n(p.begin(), 4, c.distortion);
      c.xi = p[4];
      break;
    case LensKind::kDoubleSphere:
      c.xi = p[0];
      c.alpha = p[1];
      break;
    case LensKind::kEucm:
      c.alpha = p[0];
      c.beta = p[1];
      break;
  }
}

bool Lens::bend(const Eigen::Vector3d& p_camera, Eigen::Vector3d& bent) const {
  bent = p_camera;
  if (!windshield_) return true;
  int valid = 1;
  lens_forward::bend_point(constants_.get(),
                           windshield_->reference == Windshield::Reference::kBackward,
                           &bent.x(),
                           &bent.y(),
                           &bent.z(),
                           &valid);
  return valid != 0;
}

bool Lens::forward(const Eigen::Vector3d& p_camera, Eigen::Vector2d& image) const {
  Eigen::Vector3d bent;
  const bool gets_through = bend(p_camera, bent);
  const double x = bent.x(), y = bent.y(), z = bent.z();
  const auto* const lens = constants_.get();
  double u = 0.0, v = 0.0;
  int valid = gets_through ? 1 : 0;
  namespace forward = lens_forward;
  switch (kind_) {
    case LensKind::kPinhole:
      forward::pinhole_image(x, y, z, &u, &v, &valid);
      break;
    case LensKind::kOpencvPinhole:
      forward::opencv_pinhole_image(lens, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kOpencvFisheye:
      forward::opencv_fisheye_image(lens, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kFtheta:
      forward::ftheta_image(lens, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kFthetaInverse:
      forward::ftheta_inverse_image(lens, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kMei:
      forward::mei_image(lens, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kEquirectangular:
      forward::equirectangular_image(x, y, z, &u, &v, &valid);
      break;
    case LensKind::kDoubleSphere:
      forward::double_sphere_image(lens, x, y, z, &u, &v, &valid);
      break;
    case LensKind::kEucm:
      forward::eucm_image(lens, x, y, z, &u, &v, &valid);
      break;
  }
  image = {u, v};
  return valid != 0;
}

bool Lens::project(const Eigen::Vector3d& p_camera, Eigen::Vector2d& image) const {
  Eigen::Vector2d found;
  if (!forward(p_camera, found)) return false;
  image = found;
  return true;
}

bool Lens::continued(const Eigen::Vector3d& p_camera, Eigen::Vector2d& image) const {
  Eigen::Vector3d bent;
  if (!bend(p_camera, bent)) return false;
  const double x = bent.x(), y = bent.y(), z = bent.z();
  const bool has_image = forward(p_camera, image);
  switch (kind_) {
    case LensKind::kOpencvPinhole: {
      double u = 0.0, v = 0.0;
      int valid = 1;
      lens_forward::pinhole_image(x, y, z, &u, &v, &valid);
      const double* const k = constants_->distortion;
      const double r2 = u * u + v * v;
      return valid != 0 && 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])) > 0.0;
    }
    case LensKind::kOpencvFisheye:
    case LensKind::kFtheta:
      // Straight behind, one direction maps to a circle.
      return std::hypot(x, y) > 1e-5 * bent.norm() || z > 0.0;
    default:
      return has_image;
  }
}

Eigen::Vector3d Lens::unproject(const Eigen::Vector2d& image) const {
  const Eigen::Vector3d direction = unbend(inverse(image).normalized());
  // Every image of the ideal pinhole has a ray; its limit of 84 degrees applies to projection only.
  if (kind_ == LensKind::kPinhole) return image.allFinite() ? direction : Eigen::Vector3d::Zero();
  Eigen::Vector2d again;
  if (!project(direction, again)) return Eigen::Vector3d::Zero();
  Eigen::Vector2d miss = again - image;
  if (kind_ == LensKind::kEquirectangular) miss.x() = std::remainder(miss.x(), 2.0 * kPi);
  if (!(miss.norm() <= kReprojection * (1.0 + image.norm()))) return Eigen::Vector3d::Zero();
  return direction;
}

double Lens::centre_slope() const {
  const double slope = [&] {
    switch (kind_) {
      case LensKind::kFtheta:
        return constants_->polynomial[0];
      case LensKind::kFthetaInverse:
        return 1.0 / constants_->polynomial[0];
      case LensKind::kMei:
      case LensKind::kDoubleSphere:
        return 1.0 / (1.0 + constants_->xi);
      default:
        return 1.0;
    }
  }();
  if (!windshield_) return slope;
  // Enlargement of a narrow cone about the axis by the glass.
  constexpr double kStep = 1e-4;
  Eigen::Vector3d right, left, below, above;
  bend({kStep, 0.0, 1.0}, right);
  bend({-kStep, 0.0, 1.0}, left);
  bend({0.0, kStep, 1.0}, below);
  bend({0.0, -kStep, 1.0}, above);
  return slope * std::sqrt((right - left).cross(below - above).norm()) / (2.0 * kStep);
}

}  // namespace simuli
