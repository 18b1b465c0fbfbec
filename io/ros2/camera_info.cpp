#include "io/ros2/camera_info.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <string_view>

#include "host/core/base/error.hpp"
#include "host/core/base/image.hpp"

namespace simuli::ros2 {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr char kPlumbBob[] = "plumb_bob", kRational[] = "rational_polynomial", kEquidistant[] = "equidistant";

/// The coefficients k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 max_angle are in OpenCV's order.
constexpr std::size_t kPlumbBobCount = 5, kRationalCount = 8, kEquidistantCount = 4;

/// ROS has no model of windshields; this suffix is appended to the lens's name. d: the lens's parameters, 0 or
/// 1 (forward or backward polynomials are exact), and four polynomials, each preceded by its number of
/// coefficients.
constexpr std::string_view kBehindWindshield = "_behind_windshield";

template <class Glass>
auto polynomials_of(Glass& glass) {
  return std::array{&glass.horizontal, &glass.vertical, &glass.horizontal_inverse, &glass.vertical_inverse};
}

void put_windshield(const Lens& lens, CameraInfoMessage& info) {
  const Windshield& glass = *lens.windshield();
  info.distortion_model = std::string(to_string(lens.kind())) + std::string(kBehindWindshield);
  info.d = lens.parameters();
  info.d.push_back(glass.reference == Windshield::Reference::kBackward ? 1.0 : 0.0);
  for (const auto* const polynomial : polynomials_of(glass)) {
    info.d.push_back(static_cast<double>(polynomial->size()));
    info.d.insert(info.d.end(), polynomial->begin(), polynomial->end());
  }
}

/// Parses the windshield and removes it from the end of `d`; returns false if `d` after `lens_count` parameters
/// is invalid.
bool take_windshield(std::vector<double>& d, std::size_t lens_count, Windshield& glass) {
  std::size_t at = lens_count;
  if (at >= d.size() || (d[at] != 0.0 && d[at] != 1.0)) return false;
  glass.reference = d[at++] == 1.0 ? Windshield::Reference::kBackward : Windshield::Reference::kForward;
  for (std::vector<double>* const polynomial : polynomials_of(glass)) {
    if (at >= d.size() || !(d[at] >= 1.0 && d[at] <= static_cast<double>(d.size() - at - 1))) return false;
    const auto count = static_cast<std::ptrdiff_t>(d[at++]);
    const auto first = d.begin() + static_cast<std::ptrdiff_t>(at);
    polynomial->assign(first, first + count);
    at += static_cast<std::size_t>(count);
  }
  if (at != d.size()) return false;
  d.resize(lens_count);
  return true;
}

void put_distortion(const Lens& lens, CameraInfoMessage& info) {
  const std::vector<double>& p = lens.parameters();
  const auto are_zero = [&](std::size_t first, std::size_t end) {
    return std::all_of(p.begin() + static_cast<std::ptrdiff_t>(first),
                       p.begin() + static_cast<std::ptrdiff_t>(end),
                       [](double v) { return v == 0.0; });
  };
  const auto first = [&](std::size_t count) {
    info.d.assign(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(count));
  };
  if (lens.windshield()) {
    put_windshield(lens, info);
  } else if (lens.kind() == LensKind::kPinhole) {
    info.distortion_model = kPlumbBob;
    info.d.assign(kPlumbBobCount, 0.0);
  } else if (lens.kind() == LensKind::kOpencvPinhole && are_zero(kRationalCount, p.size() - 1)) {
    const bool is_plumb_bob = are_zero(kPlumbBobCount, kRationalCount);
    info.distortion_model = is_plumb_bob ? kPlumbBob : kRational;
    first(is_plumb_bob ? kPlumbBobCount : kRationalCount);
  } else if (lens.kind() == LensKind::kOpencvFisheye) {
    info.distortion_model = kEquidistant;
    first(kEquidistantCount);
  } else {
    info.distortion_model = to_string(lens.kind());
    info.d = p;
  }
}

}  // namespace

CameraInfoMessage camera_info_of(const Camera& camera) {
  CameraInfoMessage info;
  info.height = static_cast<std::uint32_t>(camera.height);
  info.width = static_cast<std::uint32_t>(camera.width);
  put_distortion(camera.lens, info);
  const double cx = camera.cx - 0.5, cy = camera.cy - 0.5;
  info.k = {camera.fx, 0, cx, 0, camera.fy, cy, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {camera.fx, 0, cx, 0, 0, camera.fy, cy, 0, 0, 0, 1, 0};
  return info;
}

Camera camera_of(const CameraInfoMessage& info,
                 const std::string& name,
                 const std::string& file,
                 const std::string& where) {
  const auto refuse = [&](const char* field, const std::string& found, const std::string& allowed) {
    throw_input_error(file, where + ": " + field, found, allowed);
  };
  if (info.binning_x > 1 || info.binning_y > 1)
    refuse("binning", fmt::format("{} x {}", info.binning_x, info.binning_y), "none: 0 or 1");
  const bool is_whole = info.roi_x_offset == 0 && info.roi_y_offset == 0 &&
                        (info.roi_width == 0 || info.roi_width == info.width) &&
                        (info.roi_height == 0 || info.roi_height == info.height);
  if (!is_whole) refuse("roi", "a part of the picture", "the whole");
  if (info.width > static_cast<std::uint32_t>(kLargestSide_px) ||
      info.height > static_cast<std::uint32_t>(kLargestSide_px)) {
    refuse("width x height",
           fmt::format("{} x {}", info.width, info.height),
           fmt::format("at most {} a side", kLargestSide_px));
  }
  Camera camera;
  camera.name = name;
  camera.width = static_cast<int>(info.width);
  camera.height = static_cast<int>(info.height);
  camera.fx = info.k[0];
  camera.fy = info.k[4];
  camera.cx = info.k[2] + 0.5;
  camera.cy = info.k[5] + 0.5;
  if (info.k[0] == 0.0) refuse("k", "no focal length", "that of a calibrated camera");
  std::string model = info.distortion_model;
  std::vector<double> d = info.d;
  std::optional<Windshield> glass;
  if (model.ends_with(kBehindWindshield)) {
    model.resize(model.size() - kBehindWindshield.size());
    const std::size_t count = lens_parameter_names(lens_from_string(model, file, where)).size();
    if (!take_windshield(d, count, glass.emplace()))
      refuse("d", fmt::format("{} values", d.size()), "those of a lens and of a windshield");
  }
  const bool is_undistorted = std::all_of(d.begin(), d.end(), [](double v) { return v == 0.0; });
  const auto need = [&](std::size_t count) {
    if (d.size() != count)
      refuse("d", fmt::format("{} values", d.size()), fmt::format("{} of {}", count, model));
  };
  LensKind kind = LensKind::kPinhole;
  const auto known = std::find(lens_names().begin(), lens_names().end(), model);
  if ((model.empty() || model == "none" || model == kPlumbBob || model == kRational) && is_undistorted) {
    d.clear();
  } else if (model.empty() || model == kPlumbBob || model == kRational) {
    // Drivers write OpenCV's vector of any length under either name or none; missing coefficients are zero.
    constexpr std::array<std::size_t, 5> kOpencvCounts{4, 5, 8, 12, 14};
    if (std::find(kOpencvCounts.begin(), kOpencvCounts.end(), d.size()) == kOpencvCounts.end())
      refuse("d", fmt::format("{} values", d.size()), "4, 5, 8, 12 or 14 of " + model);
    kind = LensKind::kOpencvPinhole;
    d.resize(kOpencvCounts.back(), 0.0);
    if (d[12] != 0.0 || d[13] != 0.0) refuse("d", "a tilted sensor", "0 for tau_x and tau_y");
    d.resize(lens_parameter_names(kind).size() - 1);
    d.push_back(kPi);
  } else if (model == kEquidistant || model.starts_with("kannala_brandt") || model == "fisheye") {
    need(kEquidistantCount);
    kind = LensKind::kOpencvFisheye;
    d.push_back(kPi);
  } else if (known != lens_names().end()) {
    kind = lens_from_string(model, file, where);
    need(lens_parameter_names(kind).size());
  } else {
    refuse("distortion_model",
           '"' + model + '"',
           "plumb_bob, rational_polynomial, equidistant, or a lens of simuli's");
  }
  camera.lens = kind == LensKind::kPinhole ? Lens() : Lens(kind, d, file + ": " + where);
  if (glass) camera.lens = camera.lens.behind(*glass, file + ": " + where);
  validate(camera, file + ": " + where);
  return camera;
}

}  // namespace simuli::ros2
