#include "host/core/sensors/camera.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <tuple>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/image.hpp"

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
  return lens.unproject({(pixel.x() - cx) / fx, (pixel.y() - cy) / fy});
}

bool Camera::project(const Eigen::Vector3d& p_camera, Eigen::Vector2d& pixel) const {
  Eigen::Vector2d image;
  if (!lens.project(p_camera, image)) return false;
  pixel = {fx * image.x() + cx, fy * image.y() + cy};
  if (lens.kind() == LensKind::kEquirectangular) pixel.x() -= width * std::floor(pixel.x() / width);
  return true;
}

double Camera::focal_px() const { return std::sqrt(fx * fy) * lens.centre_slope(); }

double Camera::exposure_fraction(const Eigen::Vector2d& pixel) const {
  switch (shutter) {
    case ShutterKind::kGlobal:
      return 0.5;
    case ShutterKind::kTopToBottom:
      return pixel.y() / height;
    case ShutterKind::kBottomToTop:
      return 1.0 - pixel.y() / height;
    case ShutterKind::kLeftToRight:
      return pixel.x() / width;
    case ShutterKind::kRightToLeft:
      return 1.0 - pixel.x() / width;
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

void set_ftheta(Camera& camera,
                LensKind kind,
                const std::array<double, 5>& polynomial,
                const std::array<double, 3>& linear_cde,
                double max_angle_rad) {
  if (kind != LensKind::kFtheta && kind != LensKind::kFthetaInverse) {
    throw Error(ErrorKind::kInternal, "set_ftheta: another kind of lens");
  }
  const bool inverse = kind == LensKind::kFthetaInverse;
  const double focal = inverse ? 1.0 / polynomial[0] : polynomial[0];
  if (!(focal > 0.0) || !std::isfinite(focal)) {
    throw_input_error(
        "camera " + camera.name, inverse ? "b1" : "a1", fmt::format("{}", polynomial[0]), "above 0");
  }
  std::vector<double> parameters;
  double scale = inverse ? 1.0 : 1.0 / focal;
  for (const double coefficient : polynomial) {
    if (inverse) scale *= focal;  // the argument is in focal lengths: degree k gains focal^k
    parameters.push_back(coefficient * scale);
  }
  parameters.insert(parameters.end(), linear_cde.begin(), linear_cde.end());
  parameters.push_back(max_angle_rad);
  camera.fx = camera.fy = focal;
  camera.lens = Lens(kind, parameters, "camera " + camera.name);
}

ViewAngle view_angle(const Camera& camera) {
  // The angle about the other axis of the outermost ray of a row or column.
  const auto outermost = [&](double from, double to, auto&& pixel_at, auto&& angle_of) {
    const double step = to > from ? 1.0 : -1.0;
    for (double at = from; step * (to - at) >= 0.0; at += step) {
      const Eigen::Vector3d ray = camera.unproject(pixel_at(at));
      if (ray != Eigen::Vector3d::Zero()) return static_cast<double>(angle_of(ray));
    }
    return 0.0;
  };
  const auto in_row = [&](double at) { return Eigen::Vector2d(at, camera.cy); };
  const auto in_column = [&](double at) { return Eigen::Vector2d(camera.cx, at); };
  const auto right = [](const Eigen::Vector3d& ray) { return std::atan2(ray.x(), ray.z()); };
  const auto down = [](const Eigen::Vector3d& ray) { return std::atan2(ray.y(), ray.z()); };
  const double width = camera.width, height = camera.height;
  return {outermost(width, 0.0, in_row, right) - outermost(0.0, width, in_row, right),
          outermost(height, 0.0, in_column, down) - outermost(0.0, height, in_column, down)};
}

std::size_t pixels_without_ray(const Camera& camera) {
  std::size_t missing = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (camera.unproject({x + 0.5, y + 0.5}).isZero(0.0)) ++missing;
    }
  }
  return missing;
}

const char* to_string(ShutterKind kind) {
  for (const auto& [k, name] : kShutterNames) {
    if (k == kind) return name;
  }
  throw Error(ErrorKind::kInternal, "shutter kind without a name");
}

ShutterKind shutter_from_string(const std::string& name, const std::string& file, const std::string& field) {
  for (const auto& [kind, known] : kShutterNames) {
    if (name == known) return kind;
  }
  throw_input_error(
      file, field, '"' + name + '"', "global, top_to_bottom, bottom_to_top, left_to_right or right_to_left");
}

void validate(const Camera& camera, const std::string& file) {
  const std::string prefix = camera.name.empty() ? "" : "camera " + camera.name + ": ";
  for (const auto& [field, value] : {std::pair{"width_px", camera.width}, {"height_px", camera.height}}) {
    if (value < 1 || value > kLargestSide_px) {
      throw_input_error(file, prefix + field, std::to_string(value), fmt::format("1 to {}", kLargestSide_px));
    }
  }
  // Limits in sides of the picture: at a thousandth a pinhole's picture spans 179.8 degrees, at a million 0.2
  // arc seconds.
  constexpr double kShortest = 1e-3, kLongest = 1e6;
  for (const auto& [field, value, side_px] :
       {std::tuple{"fx_px", camera.fx, camera.width}, {"fy_px", camera.fy, camera.height}}) {
    if (!(value >= kShortest * side_px && value <= kLongest * side_px)) {
      throw_input_error(
          file,
          prefix + field,
          fmt::format("{}", value),
          fmt::format("{:g} to {:g} (of {} px)", kShortest * side_px, kLongest * side_px, side_px));
    }
  }
  for (const auto& [field, value] : {std::pair{"cx_px", camera.cx}, {"cy_px", camera.cy}}) {
    if (!std::isfinite(value)) {
      throw_input_error(file, prefix + field, fmt::format("{}", value), "finite");
    }
  }
  if (camera.lens.kind() != LensKind::kEquirectangular) return;
  constexpr double kTurnTolerance = 1e-6;  // of the width: 1/15 pixel of the widest picture
  const double turn_px = 2.0 * std::numbers::pi * camera.fx;
  if (!(std::abs(turn_px / camera.width - 1.0) <= kTurnTolerance)) {
    throw_input_error(file,
                      prefix + "fx_px",
                      fmt::format("{} (a turn of {} px)", camera.fx, turn_px),
                      fmt::format("width / 2 pi = {}", camera.width / (2.0 * std::numbers::pi)));
  }
  if (camera.shutter == ShutterKind::kLeftToRight || camera.shutter == ShutterKind::kRightToLeft) {
    throw_input_error(file,
                      prefix + "shutter",
                      to_string(camera.shutter),
                      "global, top_to_bottom or bottom_to_top with an equirectangular lens");
  }
}

}  // namespace simuli
