#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <numbers>

#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/info/info.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli::cli {
namespace {

constexpr double kDegPerRadian = 180.0 / std::numbers::pi;

}  // namespace

std::string camera_line(const Camera& c) {
  const ViewAngle angle = view_angle(c);
  return fmt::format(
      "camera {:<16} {}, {} x {} px, view {:.1f} x {:.1f} deg, focal {:.1f} x {:.1f} px, shutter {}",
      c.name,
      simuli::to_string(c.lens.kind()),
      c.width,
      c.height,
      angle.horizontal_rad * kDegPerRadian,
      angle.vertical_rad * kDegPerRadian,
      c.fx,
      c.fy,
      simuli::to_string(c.shutter));
}

nlohmann::ordered_json camera_summary(const Camera& c) {
  const ViewAngle angle = view_angle(c);
  return {{"name", c.name},
          {"lens", simuli::to_string(c.lens.kind())},
          {"width_px", c.width},
          {"height_px", c.height},
          {"view_horizontal_deg", angle.horizontal_rad * kDegPerRadian},
          {"view_vertical_deg", angle.vertical_rad * kDegPerRadian},
          {"shutter", simuli::to_string(c.shutter)}};
}

void print_sensor(const CameraFile& file, bool json) {
  if (json) {
    std::cout << json_text(simuli::to_json(file)) << '\n';
    return;
  }
  const Camera& camera = file.model;
  std::cout << camera_line(camera) << '\n'
            << fmt::format("  centre {:.2f}, {:.2f} px\n", camera.cx, camera.cy);
  const auto& names = lens_parameter_names(camera.lens.kind());
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::cout << fmt::format("  {} {}\n", names[i], camera.lens.parameters()[i]);
  }
  if (const std::optional<Windshield>& glass = camera.lens.windshield()) {
    std::cout << fmt::format("  behind a windshield, {} polynomials exact\n",
                             glass->reference == Windshield::Reference::kForward ? "forward" : "backward")
              << fmt::format("  horizontal {}\n", fmt::join(glass->horizontal, " "))
              << fmt::format("  vertical {}\n", fmt::join(glass->vertical, " "))
              << fmt::format("  horizontal, back {}\n", fmt::join(glass->horizontal_inverse, " "))
              << fmt::format("  vertical, back {}\n", fmt::join(glass->vertical_inverse, " "));
  }
  const double pixels = static_cast<double>(camera.width) * camera.height;
  const std::size_t missing = pixels_without_ray(camera);
  std::cout << fmt::format(
      "  {} pixels without a ray, {:.2f} %\n", missing, 100.0 * static_cast<double>(missing) / pixels);
  if (file.readout_s > 0.0) std::cout << fmt::format("  read out in {} s\n", file.readout_s);
  std::cout << origin_text(file.source, file.licence, file.note);
}

std::string origin_text(const std::string& source, const std::string& licence, const std::string& note) {
  std::string text;
  if (!source.empty()) text += fmt::format("  source {}\n", source);
  if (!licence.empty()) text += fmt::format("  licence {}\n", licence);
  if (!note.empty()) text += fmt::format("  note {}\n", note);
  return text;
}

}  // namespace simuli::cli
