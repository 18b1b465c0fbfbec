#include <vector>

#include "io/export/drive_parts.hpp"
#include "io/export/ftheta_camera.hpp"

namespace simuli {
namespace {

const char* shutter_name(ShutterKind kind) {
  switch (kind) {
    case ShutterKind::kTopToBottom:
      return "ROLLING_TOP_TO_BOTTOM";
    case ShutterKind::kBottomToTop:
      return "ROLLING_BOTTOM_TO_TOP";
    case ShutterKind::kLeftToRight:
      return "ROLLING_LEFT_TO_RIGHT";
    case ShutterKind::kRightToLeft:
      return "ROLLING_RIGHT_TO_LEFT";
    case ShutterKind::kGlobal:
      break;
  }
  return "GLOBAL";
}

/// Returns the lens parameters with these indices.
Json picked(const std::vector<double>& all, std::initializer_list<std::size_t> places) {
  Json out = Json::array();
  for (const std::size_t i : places) out.push_back(all[i]);
  return out;
}

Json windshield_json(const std::optional<Windshield>& glass) {
  if (!glass) return nullptr;
  return {{"external_distortion_type", "bivariate-windshield"},
          {"reference_poly", glass->reference == Windshield::Reference::kForward ? "FORWARD" : "BACKWARD"},
          {"horizontal_poly", glass->horizontal},
          {"vertical_poly", glass->vertical},
          {"horizontal_poly_inverse", glass->horizontal_inverse},
          {"vertical_poly_inverse", glass->vertical_inverse}};
}

}  // namespace

Json camera_model_of(const Camera& camera) {
  Json p{{"resolution", {camera.width, camera.height}},
         {"shutter_type", shutter_name(camera.shutter)},
         {"external_distortion_parameters", windshield_json(camera.lens.windshield())},
         {"principal_point", {camera.cx, camera.cy}},
         {"focal_length", {camera.fx, camera.fy}}};
  std::vector<double> all = camera.lens.parameters();
  switch (camera.lens.kind()) {
    case LensKind::kPinhole:
    case LensKind::kOpencvPinhole:
      all.resize(13, 0.0);  // an ideal lens has none
      p["radial_coeffs"] = picked(all, {0, 1, 4, 5, 6, 7});
      p["tangential_coeffs"] = picked(all, {2, 3});
      p["thin_prism_coeffs"] = picked(all, {8, 9, 10, 11});
      return {{"type", "opencv-pinhole"}, {"parameters", p}};
    case LensKind::kOpencvFisheye:
      p["radial_coeffs"] = picked(all, {0, 1, 2, 3});
      p["max_angle"] = all[4];
      return {{"type", "opencv-fisheye"}, {"parameters", p}};
    case LensKind::kFtheta:
    case LensKind::kFthetaInverse: {
      const FthetaCamera ftheta = ftheta_of(camera);
      p.erase("focal_length");
      p["principal_point"] = ftheta.principal_point;
      p["reference_poly"] = ftheta.is_inverse ? "PIXELDIST_TO_ANGLE" : "ANGLE_TO_PIXELDIST";
      p["pixeldist_to_angle_poly"] = ftheta.pixels_to_angle;
      p["angle_to_pixeldist_poly"] = ftheta.angle_to_pixels;
      p["max_angle"] = ftheta.max_angle_rad;
      p["linear_cde"] = ftheta.linear_cde;
      return {{"type", "ftheta"}, {"parameters", p}};
    }
    case LensKind::kMei:
    case LensKind::kEquirectangular:
    case LensKind::kDoubleSphere:
    case LensKind::kEucm:
      break;
  }
  return nullptr;
}

Json rows_of(const Eigen::Matrix4d& matrix) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
  return rows;
}

Json camera_calibration(const LogCamera& camera, const std::string& sequence, std::size_t index) {
  Json model = camera_model_of(camera.model);
  if (model.is_null()) {
    model = {{"type", kUnknownLens},
             {"parameters",
              {{"resolution", {camera.model.width, camera.model.height}},
               {"shutter_type", shutter_name(camera.model.shutter)},
               {"external_distortion_parameters", nullptr},
               {"principal_point", {camera.model.cx, camera.model.cy}}}}};
  }
  // CARLA's client requires the f-theta keys for all cameras.
  for (const char* key :
       {"reference_poly", "pixeldist_to_angle_poly", "angle_to_pixeldist_poly", "max_angle", "linear_cde"}) {
    Json& parameters = model["parameters"];
    if (!parameters.contains(key)) parameters[key] = nullptr;
  }
  return {{"logical_sensor_name", camera.model.name},
          {"sequence_id", sequence},
          {"unique_sensor_idx", index},
          {"T_sensor_rig", rows_of(camera.rig_from_camera.matrix())},
          {"camera_model", model}};
}

}  // namespace simuli
