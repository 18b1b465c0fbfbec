#include "host/sensors/camera.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "host/base/error.hpp"

namespace simuli {
namespace {

constexpr std::array<std::pair<ShutterKind, const char*>, 5> kShutterNames{{
    {ShutterKind::kGlobal, "global"},
    {ShutterKind::kTopToBottom, "top_to_bottom"},
    {ShutterKind::kBottomToTop, "bottom_to_top"},
    {ShutterKind::kLeftToRight, "left_to_right"},
    {ShutterKind::kRightToLeft, "right_to_left"},
}};

}  // namespace

Eigen::Vector3d Camera::unproject(const Eigen::Vector2d& pixel) const {
  return Eigen::Vector3d((pixel.x() - cx) / fx, (pixel.y() - cy) / fy, 1.0).normalized();
}

bool Camera::project(const Eigen::Vector3d& p_camera, Eigen::Vector2d& pixel) const {
  if (!(p_camera.z() > 0.0)) return false;
  pixel = {fx * p_camera.x() / p_camera.z() + cx, fy * p_camera.y() / p_camera.z() + cy};
  return true;
}

double Camera::exposure_fraction(const Eigen::Vector2d& pixel) const {
  switch (shutter) {
    case ShutterKind::kGlobal: return 0.5;
    case ShutterKind::kTopToBottom: return pixel.y() / height;
    case ShutterKind::kBottomToTop: return 1.0 - pixel.y() / height;
    case ShutterKind::kLeftToRight: return pixel.x() / width;
    case ShutterKind::kRightToLeft: return 1.0 - pixel.x() / width;
  }
  return 0.5;
}

Camera Camera::resized(int new_width, int new_height) const {
  Camera out = *this;
  const double sx = static_cast<double>(new_width) / width;
  const double sy = static_cast<double>(new_height) / height;
  out.width = new_width;
  out.height = new_height;
  out.fx *= sx;
  out.cx *= sx;
  out.fy *= sy;
  out.cy *= sy;
  return out;
}

const char* to_string(ShutterKind kind) {
  for (const auto& [k, name] : kShutterNames) {
    if (k == kind) return name;
  }
  throw Error(ErrorKind::kInternal, "shutter kind without a name");
}

ShutterKind shutter_from_string(const std::string& name,
                                const std::string& file,
                                const std::string& field) {
  for (const auto& [kind, known] : kShutterNames) {
    if (name == known) return kind;
  }
  throw_input_error(file,
                    field,
                    '"' + name + '"',
                    "global, top_to_bottom, bottom_to_top, left_to_right or right_to_left");
}

void validate(const Camera& camera, const std::string& file) {
  const std::string prefix = "camera " + camera.name + ": ";
  for (const auto& [field, value] : {std::pair{"width_px", camera.width}, {"height_px", camera.height}}) {
    if (value < 1 || value > 65536) {
      throw_input_error(file, prefix + field, std::to_string(value), "1 to 65536");
    }
  }
  for (const auto& [field, value] : {std::pair{"fx_px", camera.fx}, {"fy_px", camera.fy}}) {
    if (!(value > 0.0) || !std::isfinite(value)) {
      throw_input_error(file, prefix + field, fmt::format("{}", value), "finite and above 0");
    }
  }
  for (const auto& [field, value] : {std::pair{"cx_px", camera.cx}, {"cy_px", camera.cy}}) {
    if (!std::isfinite(value)) {
      throw_input_error(file, prefix + field, fmt::format("{}", value), "finite");
    }
  }
}

}  // namespace simuli
