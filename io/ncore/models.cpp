#include "io/ncore/models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/export/drive_parts.hpp"

namespace simuli::ncore {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kFirstCentre = 0.5;
constexpr const char* kCameraType = "camera_model_type";
constexpr const char* kCameraParameters = "camera_model_parameters";
constexpr const char* kOutside = "external_distortion_parameters";
constexpr const char* kOutsideType = "external_distortion_type";
constexpr const char* kWindshield = "bivariate-windshield";
constexpr const char* kLidarType = "lidar_model_type";
constexpr const char* kLidarParameters = "lidar_model_parameters";
constexpr const char* kSpinning = "row-offset-spinning";

ShutterKind shutter_of(JsonObject& p) {
  constexpr std::array<std::pair<const char*, ShutterKind>, 5> kNames{
      {{"ROLLING_TOP_TO_BOTTOM", ShutterKind::kTopToBottom},
       {"ROLLING_LEFT_TO_RIGHT", ShutterKind::kLeftToRight},
       {"ROLLING_BOTTOM_TO_TOP", ShutterKind::kBottomToTop},
       {"ROLLING_RIGHT_TO_LEFT", ShutterKind::kRightToLeft},
       {"GLOBAL", ShutterKind::kGlobal}}};
  const std::string name = p.text("shutter_type");
  for (const auto& [known, kind] : kNames) {
    if (name == known) return kind;
  }
  throw_input_error(p.file(),
                    p.field("shutter_type"),
                    '"' + name.substr(0, 60) + '"',
                    "GLOBAL or ROLLING_TOP_TO_BOTTOM, _LEFT_TO_RIGHT, _BOTTOM_TO_TOP, _RIGHT_TO_LEFT");
}

/// Returns the coefficients of a polynomial, at most `most`, padded with zeros.
std::vector<double> padded(JsonObject& p, const std::string& key, std::size_t most) {
  std::vector<double> out = p.numbers(key);
  if (out.size() > most) {
    throw_input_error(
        p.file(), p.field(key), fmt::format("{} numbers", out.size()), fmt::format("at most {}", most));
  }
  out.resize(most, 0.0);
  return out;
}

double angle_of(JsonObject& p) { return std::min(p.number("max_angle", 0.0), std::numbers::pi); }

void set_focal(JsonObject& p, Camera& camera) {
  const Eigen::Vector2d focal = p.vector<2>("focal_length");
  camera.fx = focal.x();
  camera.fy = focal.y();
}

void set_ftheta_lens(JsonObject& p, Camera& camera) {
  const std::string reference = p.text("reference_poly");
  const bool is_inverse = reference == "PIXELDIST_TO_ANGLE";
  if (!is_inverse && reference != "ANGLE_TO_PIXELDIST") {
    throw_input_error(p.file(),
                      p.field("reference_poly"),
                      '"' + reference.substr(0, 60) + '"',
                      "PIXELDIST_TO_ANGLE or ANGLE_TO_PIXELDIST");
  }
  const std::string key = is_inverse ? "pixeldist_to_angle_poly" : "angle_to_pixeldist_poly";
  const std::vector<double> all = padded(p, key, 6);
  if (all[0] != 0.0) throw_input_error(p.file(), p.field(key), fmt::format("{} of degree 0", all[0]), "0");
  std::array<double, 3> cde{1.0, 0.0, 0.0};
  if (p.has("linear_cde")) {
    const Eigen::Vector3d given = p.vector<3>("linear_cde");
    // Some recordings have a zero linear part, which means that it is absent.
    if (!given.isZero()) cde = {given[0], given[1], given[2]};
  }
  camera.cx += kFirstCentre;
  camera.cy += kFirstCentre;
  set_ftheta(camera,
             is_inverse ? LensKind::kFthetaInverse : LensKind::kFtheta,
             {all[1], all[2], all[3], all[4], all[5]},
             cde,
             angle_of(p));
}

Windshield windshield_of(JsonObject& p, const std::string& type_beside) {
  const std::string type = p.has(kOutsideType) ? p.text(kOutsideType) : type_beside;
  if (type != kWindshield) {
    throw_input_error(p.file(), p.field(kOutsideType), '"' + type.substr(0, 60) + '"', kWindshield);
  }
  const std::string reference = p.text("reference_poly");
  if (reference != "FORWARD" && reference != "BACKWARD") {
    throw_input_error(
        p.file(), p.field("reference_poly"), '"' + reference.substr(0, 60) + '"', "FORWARD or BACKWARD");
  }
  return {reference == "FORWARD" ? Windshield::Reference::kForward : Windshield::Reference::kBackward,
          p.numbers("horizontal_poly"),
          p.numbers("vertical_poly"),
          p.numbers("horizontal_poly_inverse"),
          p.numbers("vertical_poly_inverse")};
}

void set_lens(JsonObject& p, const std::string& type, Camera& camera) {
  if (type == "ftheta") return set_ftheta_lens(p, camera);
  set_focal(p, camera);
  if (type == "ideal-pinhole") return;
  if (type == "opencv-fisheye") {
    std::vector<double> all = padded(p, "radial_coeffs", 4);
    all.push_back(angle_of(p));
    camera.lens = Lens(LensKind::kOpencvFisheye, all, p.file());
    return;
  }
  const std::vector<double> k = padded(p, "radial_coeffs", 6), t = padded(p, "tangential_coeffs", 2),
                            s = padded(p, "thin_prism_coeffs", 4);
  const std::vector<double> all{
      k[0], k[1], t[0], t[1], k[2], k[3], k[4], k[5], s[0], s[1], s[2], s[3], std::numbers::pi};
  if (std::all_of(all.begin(), all.end() - 1, [](double value) { return value == 0.0; })) return;
  camera.lens = Lens(LensKind::kOpencvPinhole, all, p.file());
}

}  // namespace

Json intrinsics_of(const Camera& camera) {
  Json model = camera_model_of(camera);
  if (model.is_null()) return nullptr;
  Json out{{kCameraType, model["type"]}, {kCameraParameters, std::move(model["parameters"])}};
  if (camera.lens.windshield()) out[kOutsideType] = kWindshield;  // for readers that search outside the model
  return out;
}

Json intrinsics_of(const LidarModel& model) {
  const Lidar* lidar = std::get_if<Lidar>(&model);
  if (lidar == nullptr) return nullptr;
  Json elevations = Json::array(), offsets = Json::array(), azimuths = Json::array();
  for (std::size_t i = 0; i < lidar->rows.size(); ++i) {
    const LidarRow& row = lidar->rows[i];
    // In single precision, as NCore's package compares.
    if (i > 0 && !(static_cast<float>(row.elevation) < static_cast<float>(lidar->rows[i - 1].elevation)))
      return nullptr;
    elevations.push_back(row.elevation);
    offsets.push_back(row.azimuth_offset);
  }
  const double step = lidar->spin_sign() * lidar->azimuth_span / lidar->columns;
  for (int i = 0; i < lidar->columns; ++i)
    azimuths.push_back(std::remainder(lidar->azimuth_first + step * i, kTurn));
  const bool is_clockwise = lidar->spin == SpinDirection::kClockwise;
  return {{kLidarType, kSpinning},
          {kLidarParameters,
           {{"spinning_frequency_hz", 1.0 / lidar->sweep_s},
            {"spinning_direction", is_clockwise ? "cw" : "ccw"},
            {"n_rows", lidar->row_count()},
            {"n_columns", lidar->columns},
            {"row_elevations_rad", std::move(elevations)},
            {"column_azimuths_rad", std::move(azimuths)},
            {"row_azimuth_offsets_rad", std::move(offsets)}}}};
}

Camera camera_from_intrinsics(JsonObject& intrinsics, const std::string& name) {
  intrinsics.ignore_other_keys();
  const std::string type = intrinsics.text(kCameraType);
  constexpr std::array<const char*, 4> kKnown{"ftheta", "opencv-pinhole", "opencv-fisheye", "ideal-pinhole"};
  if (std::find(kKnown.begin(), kKnown.end(), type) == kKnown.end()) {
    throw_input_error(intrinsics.file(),
                      intrinsics.field(kCameraType),
                      '"' + type.substr(0, 60) + '"',
                      "ftheta, opencv-pinhole, opencv-fisheye or ideal-pinhole");
  }
  return intrinsics.object(kCameraParameters, [&](JsonObject& p) {
    p.ignore_other_keys();
    Camera camera;
    camera.name = name;
    const Eigen::Vector2d size = p.vector<2>("resolution"), centre = p.vector<2>("principal_point");
    constexpr double kLargest = 65536.0;
    if (!(size.minCoeff() >= 1.0 && size.maxCoeff() <= kLargest)) {
      throw_input_error(
          p.file(), p.field("resolution"), fmt::format("{} x {}", size.x(), size.y()), "1 to 65536");
    }
    camera.width = static_cast<int>(size.x());
    camera.height = static_cast<int>(size.y());
    camera.cx = centre.x();
    camera.cy = centre.y();
    camera.shutter = shutter_of(p);
    set_lens(p, type, camera);
    if (p.has(kOutside) && !p.get(kOutside).is_null()) {
      // Older recordings have the polynomials without the type, or the type outside the model.
      const std::string beside = intrinsics.has(kOutsideType) ? intrinsics.text(kOutsideType) : kWindshield;
      camera.lens = p.object(kOutside, [&](JsonObject& glass) {
        return camera.lens.behind(windshield_of(glass, beside), p.file());
      });
    }
    validate(camera, p.file());
    return camera;
  });
}

Lidar lidar_from_intrinsics(JsonObject& intrinsics, const std::string& name) {
  intrinsics.ignore_other_keys();
  const std::string type = intrinsics.text(kLidarType);
  if (type != kSpinning) {
    throw_input_error(
        intrinsics.file(), intrinsics.field(kLidarType), '"' + type.substr(0, 60) + '"', kSpinning);
  }
  return intrinsics.object(kLidarParameters, [&](JsonObject& p) {
    p.ignore_other_keys();
    const std::vector<double> elevations = p.numbers("row_elevations_rad"),
                              offsets = p.numbers("row_azimuth_offsets_rad"),
                              azimuths = p.numbers("column_azimuths_rad");
    constexpr std::size_t kMostRays = std::size_t{1} << 24U;
    if (elevations.size() != offsets.size() || elevations.empty() || azimuths.size() < 2 ||
        azimuths.size() > kMostRays / elevations.size()) {
      throw_input_error(
          p.file(),
          p.field("row_elevations_rad"),
          fmt::format("{} rows, {} offsets, {} columns", elevations.size(), offsets.size(), azimuths.size()),
          "an offset for each row, 2 columns at least and 2^24 rays at most");
    }
    Lidar lidar;
    lidar.name = name;
    lidar.sweep_s = 1.0 / p.number("spinning_frequency_hz", 1.0 / kLongestSweep_s);
    const std::string spin = p.text("spinning_direction");
    if (spin != "cw" && spin != "ccw")
      throw_input_error(p.file(), p.field("spinning_direction"), '"' + spin.substr(0, 60) + '"', "cw or ccw");
    lidar.spin = spin == "cw" ? SpinDirection::kClockwise : SpinDirection::kCounterClockwise;
    for (std::size_t i = 0; i < elevations.size(); ++i) {
      LidarRow row;
      row.elevation = elevations[i];
      row.azimuth_offset = std::remainder(offsets[i], kTurn);
      lidar.rows.push_back(row);
    }
    const auto last = static_cast<double>(azimuths.size() - 1);
    const auto turned = [&](double azimuth) {
      const double out = std::remainder(lidar.spin_sign() * (azimuth - azimuths.front()), kTurn);
      return out < 0.0 ? out + kTurn : out;
    };
    const double step = turned(azimuths.back()) / last;
    for (std::size_t i = 0; i < azimuths.size(); ++i) {
      if (std::abs(std::remainder(turned(azimuths[i]) - step * static_cast<double>(i), kTurn)) <= 0.5 * step)
        continue;
      throw_input_error(p.file(),
                        fmt::format("{}[{}]", p.field("column_azimuths_rad"), i),
                        fmt::format("{} rad", azimuths[i]),
                        "evenly spread columns, half of one off at most");
    }
    lidar.columns = static_cast<int>(azimuths.size());
    lidar.azimuth_first = azimuths.front();
    lidar.azimuth_span = std::min(step * (last + 1.0), kTurn);
    return lidar;
  });
}

bool is_same(const Json& a, const Json& b) {
  if (a.is_number() && b.is_number()) {
    const auto x = static_cast<float>(a.get<double>()), y = static_cast<float>(b.get<double>());
    return x == y;
  }
  if (a.type() != b.type() || a.size() != b.size()) return false;
  if (a.is_array()) return std::equal(a.begin(), a.end(), b.begin(), is_same);
  if (!a.is_object()) return a == b;
  return std::all_of(a.items().begin(), a.items().end(), [&](const auto& item) {
    const auto found = b.find(item.key());
    return found != b.end() && is_same(item.value(), *found);
  });
}

}  // namespace simuli::ncore
