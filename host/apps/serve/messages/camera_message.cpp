#include "host/apps/serve/messages/camera_message.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <google/protobuf/repeated_field.h>
#include <numbers>

#include "host/apps/serve/session/refusal.hpp"
#include "host/core/base/image.hpp"
#include "io/export/ftheta_camera.hpp"

namespace simuli::serve {
namespace {

constexpr const char* kWhere = "camera_intrinsics";
constexpr double kPi = std::numbers::pi;
using Coefficients = google::protobuf::RepeatedField<double>;

// F-theta cameras count pixels from the centre of the first one, all other cameras from the corner of the
// picture, as this project does.
constexpr double kFirstCentre = 0.5;

struct ShutterPair {
  ShutterKind kind;
  proto::ShutterType type;
};
constexpr std::array<ShutterPair, 5> kShutters{{
    {ShutterKind::kGlobal, proto::GLOBAL},
    {ShutterKind::kTopToBottom, proto::ROLLING_TOP_TO_BOTTOM},
    {ShutterKind::kBottomToTop, proto::ROLLING_BOTTOM_TO_TOP},
    {ShutterKind::kLeftToRight, proto::ROLLING_LEFT_TO_RIGHT},
    {ShutterKind::kRightToLeft, proto::ROLLING_RIGHT_TO_LEFT},
}};

ShutterKind shutter_of(proto::ShutterType type) {
  const auto found =
      std::find_if(kShutters.begin(), kShutters.end(), [&](const ShutterPair& s) { return s.type == type; });
  if (found == kShutters.end()) {
    refuse("shutter_type", fmt::format("{}", static_cast<int>(type)), "1 to 4 (rolling), 5 (global)");
  }
  return found->kind;
}

/// Returns the N coefficients of a lens; missing ones are 0.
template <std::size_t N>
std::array<double, N> filled(const Coefficients& given, const char* field) {
  if (static_cast<std::size_t>(given.size()) > N) {
    refuse(field, fmt::format("{} coefficients", given.size()), fmt::format("at most {}", N));
  }
  std::array<double, N> all{};
  std::copy(given.begin(), given.end(), all.begin());
  return all;
}

/// Returns the angle beyond which a lens has no image, if there is one.
double limit_of(double max_angle, const char* field) {
  if (max_angle == 0.0) return kPi;  // not set
  if (!(max_angle > 0.0 && std::isfinite(max_angle))) {
    refuse(field, fmt::format("{}", max_angle), "above 0, or 0 for none");
  }
  return std::min(max_angle, kPi);
}

template <class Parameters>
void set_focal(Camera& camera, const Parameters& p) {
  camera.fx = p.focal_length_x();
  camera.fy = p.focal_length_y();
  camera.cx = p.principal_point_x();
  camera.cy = p.principal_point_y();
}

void set_pinhole(Camera& camera, const proto::OpenCVPinholeCameraParam& p) {
  set_focal(camera, p);
  const auto k = filled<6>(p.radial_coeffs(), "radial_coeffs");
  const auto t = filled<2>(p.tangential_coeffs(), "tangential_coeffs");
  const auto s = filled<4>(p.thin_prism_coeffs(), "thin_prism_coeffs");
  const std::vector<double> all{k[0], k[1], t[0], t[1], k[2], k[3], k[4], k[5], s[0], s[1], s[2], s[3], kPi};
  const bool is_ideal = std::all_of(all.begin(), all.end() - 1, [](double value) { return value == 0.0; });
  camera.lens = is_ideal ? Lens() : Lens(LensKind::kOpencvPinhole, all, kWhere);
}

void set_fisheye(Camera& camera, const proto::OpenCVFisheyeCameraParam& p) {
  set_focal(camera, p);
  const auto k = filled<4>(p.radial_coeffs(), "radial_coeffs");
  const double limit = limit_of(p.max_angle(), "opencv_fisheye_param.max_angle");
  camera.lens = Lens(LensKind::kOpencvFisheye, {k[0], k[1], k[2], k[3], limit}, kWhere);
}

void set_polynomial(Camera& camera, const proto::FthetaCameraParam& p) {
  using Param = proto::FthetaCameraParam;
  const bool is_inverse = p.reference_poly() == Param::PIXELDIST_TO_ANGLE;
  if (!is_inverse && p.reference_poly() != Param::ANGLE_TO_PIXELDIST) {
    refuse("ftheta_param.reference_poly",
           fmt::format("{}", static_cast<int>(p.reference_poly())),
           "1 (pixeldist_to_angle) or 2 (angle_to_pixeldist)");
  }
  const char* const field = is_inverse ? "pixeldist_to_angle_poly" : "angle_to_pixeldist_poly";
  const auto all = filled<6>(is_inverse ? p.pixeldist_to_angle_poly() : p.angle_to_pixeldist_poly(), field);
  if (all[0] != 0.0) {
    refuse(field, fmt::format("a coefficient of degree 0 of {}", all[0]), "0: the axis has the radius 0");
  }
  const proto::LinearCde& l = p.linear_cde();
  const bool is_set = l.linear_c() != 0.0 || l.linear_d() != 0.0 || l.linear_e() != 0.0;
  set_ftheta(camera,
             is_inverse ? LensKind::kFthetaInverse : LensKind::kFtheta,
             {all[1], all[2], all[3], all[4], all[5]},
             {is_set ? l.linear_c() : 1.0, l.linear_d(), l.linear_e()},
             limit_of(p.max_angle(), "ftheta_param.max_angle"));
  camera.cx = p.principal_point_x() + kFirstCentre;
  camera.cy = p.principal_point_y() + kFirstCentre;
}

Windshield windshield_of(const proto::BivariateWindshieldModelParameters& p) {
  using Param = proto::BivariateWindshieldModelParameters;
  if (p.reference_poly() != Param::FORWARD && p.reference_poly() != Param::BACKWARD) {
    refuse("bivariate_windshield_model_param.reference_poly",
           fmt::format("{}", static_cast<int>(p.reference_poly())),
           "0 (forward) or 1 (backward)");
  }
  const auto all = [](const auto& values) { return std::vector<double>(values.begin(), values.end()); };
  return {p.reference_poly() == Param::FORWARD ? Windshield::Reference::kForward
                                               : Windshield::Reference::kBackward,
          all(p.horizontal_poly()),
          all(p.vertical_poly()),
          all(p.horizontal_poly_inverse()),
          all(p.vertical_poly_inverse())};
}

void print_windshield(const Windshield& glass, proto::BivariateWindshieldModelParameters& p) {
  using Param = proto::BivariateWindshieldModelParameters;
  p.set_reference_poly(glass.reference == Windshield::Reference::kForward ? Param::FORWARD : Param::BACKWARD);
  p.mutable_horizontal_poly()->Add(glass.horizontal.begin(), glass.horizontal.end());
  p.mutable_vertical_poly()->Add(glass.vertical.begin(), glass.vertical.end());
  p.mutable_horizontal_poly_inverse()->Add(glass.horizontal_inverse.begin(), glass.horizontal_inverse.end());
  p.mutable_vertical_poly_inverse()->Add(glass.vertical_inverse.begin(), glass.vertical_inverse.end());
}

template <class Parameters>
void print_focal(const Camera& camera, Parameters& p) {
  p.set_focal_length_x(camera.fx);
  p.set_focal_length_y(camera.fy);
  p.set_principal_point_x(camera.cx);
  p.set_principal_point_y(camera.cy);
}

void print_pinhole(const Camera& camera, proto::OpenCVPinholeCameraParam& p) {
  print_focal(camera, p);
  std::vector<double> all = camera.lens.parameters();
  all.resize(13, 0.0);  // an ideal lens has none
  for (const std::size_t i : {0, 1, 4, 5, 6, 7}) p.add_radial_coeffs(all[i]);
  for (const std::size_t i : {2, 3}) p.add_tangential_coeffs(all[i]);
  for (const std::size_t i : {8, 9, 10, 11}) p.add_thin_prism_coeffs(all[i]);
}

void print_fisheye(const Camera& camera, proto::OpenCVFisheyeCameraParam& p) {
  print_focal(camera, p);
  const std::vector<double>& all = camera.lens.parameters();
  for (std::size_t i = 0; i < 4; ++i) p.add_radial_coeffs(all[i]);
  p.set_max_angle(all[4]);
}

/// Writes the reference polynomial only.
void print_polynomial(const Camera& camera, proto::FthetaCameraParam& p) {
  const FthetaCamera ftheta = ftheta_of(camera);
  p.set_reference_poly(ftheta.is_inverse ? proto::FthetaCameraParam::PIXELDIST_TO_ANGLE
                                         : proto::FthetaCameraParam::ANGLE_TO_PIXELDIST);
  const auto& polynomial = ftheta.is_inverse ? ftheta.pixels_to_angle : ftheta.angle_to_pixels;
  auto& reported =
      ftheta.is_inverse ? *p.mutable_pixeldist_to_angle_poly() : *p.mutable_angle_to_pixeldist_poly();
  reported.Add(polynomial.begin(), polynomial.end());
  p.mutable_linear_cde()->set_linear_c(ftheta.linear_cde[0]);
  p.mutable_linear_cde()->set_linear_d(ftheta.linear_cde[1]);
  p.mutable_linear_cde()->set_linear_e(ftheta.linear_cde[2]);
  p.set_max_angle(ftheta.max_angle_rad);
  p.set_principal_point_x(ftheta.principal_point[0]);
  p.set_principal_point_y(ftheta.principal_point[1]);
}

}  // namespace

proto::CameraSpec spec_of(const Camera& camera) {
  proto::CameraSpec spec;
  spec.set_logical_id(camera.name);
  spec.set_resolution_h(static_cast<std::uint32_t>(camera.height));
  spec.set_resolution_w(static_cast<std::uint32_t>(camera.width));
  for (const ShutterPair& s : kShutters) {
    if (s.kind == camera.shutter) spec.set_shutter_type(s.type);
  }
  switch (camera.lens.kind()) {
    case LensKind::kPinhole:
    case LensKind::kOpencvPinhole:
      print_pinhole(camera, *spec.mutable_opencv_pinhole_param());
      break;
    case LensKind::kOpencvFisheye:
      print_fisheye(camera, *spec.mutable_opencv_fisheye_param());
      break;
    case LensKind::kFtheta:
    case LensKind::kFthetaInverse:
      print_polynomial(camera, *spec.mutable_ftheta_param());
      break;
    case LensKind::kMei:
    case LensKind::kEquirectangular:
    case LensKind::kDoubleSphere:
    case LensKind::kEucm:
      break;
  }
  if (camera.lens.windshield()) {
    print_windshield(*camera.lens.windshield(), *spec.mutable_bivariate_windshield_model_param());
  }
  return spec;
}

Camera camera_of(const proto::CameraSpec& spec) {
  for (const auto& [field, side] :
       {std::pair{"resolution_h", spec.resolution_h()}, {"resolution_w", spec.resolution_w()}}) {
    if (side < 1 || side > static_cast<std::uint32_t>(kLargestSide_px)) {
      refuse(fmt::format("{}.{}", kWhere, field),
             fmt::format("{}", side),
             fmt::format("1 to {}", kLargestSide_px));
    }
  }
  Camera camera;
  camera.name = spec.logical_id();
  camera.width = static_cast<int>(spec.resolution_w());
  camera.height = static_cast<int>(spec.resolution_h());
  camera.shutter = shutter_of(spec.shutter_type());
  switch (spec.camera_param_case()) {
    case proto::CameraSpec::kFthetaParam:
      set_polynomial(camera, spec.ftheta_param());
      break;
    case proto::CameraSpec::kOpencvPinholeParam:
      set_pinhole(camera, spec.opencv_pinhole_param());
      break;
    case proto::CameraSpec::kOpencvFisheyeParam:
      set_fisheye(camera, spec.opencv_fisheye_param());
      break;
    case proto::CameraSpec::CAMERA_PARAM_NOT_SET:
      refuse("camera_intrinsics.camera_param",
             "none",
             "one of ftheta, opencv_pinhole, opencv_fisheye, or the logical_id of a camera of the scene");
  }
  if (spec.has_bivariate_windshield_model_param()) {
    camera.lens = camera.lens.behind(windshield_of(spec.bivariate_windshield_model_param()), kWhere);
  }
  validate(camera, kWhere);
  if (camera.name.empty()) camera.name = "asked";  // a Sensor needs a name, which requests may omit
  return camera;
}

}  // namespace simuli::serve
