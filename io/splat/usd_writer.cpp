#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <string>

#include "io/splat/splat_axes.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {
namespace {

/// Returns the lines of an array of `count` elements with `components` numbers each, in the shortest decimal
/// form that reads as the same float.
template <class Value>
void append_array(
    std::string& to, const char* declaration, Eigen::Index count, int components, Value&& value) {
  auto out = std::back_inserter(to);
  fmt::format_to(out, "    {} = [", declaration);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (i > 0) to += ", ";
    if (components > 1) to += '(';
    for (int c = 0; c < components; ++c) {
      if (c > 0) to += ", ";
      fmt::format_to(out, "{}", static_cast<float>(value(i, c)));
    }
    if (components > 1) to += ')';
  }
  to += ']';
}

/// Returns the corners of the box around all particles, extended by three standard deviations of the longest
/// axis.
Eigen::Matrix<float, 2, 3> extent_of_splats(const GaussianSet& set) {
  Eigen::Matrix<float, 2, 3> corners = Eigen::Matrix<float, 2, 3>::Zero();
  if (set.size() == 0) return corners;
  const Eigen::VectorXf reach = 3.0F * set.log_scale().rowwise().maxCoeff().array().exp();
  corners.row(0) = (set.mean().colwise() - reach).colwise().minCoeff();
  corners.row(1) = (set.mean().colwise() + reach).colwise().maxCoeff();
  return corners;
}

}  // namespace

std::string usda_of(const GaussianSet& own, SplatAxes axes, const std::string& file) {
  need_camera_set(own, file);
  const bool is_z_up = axes == SplatAxes::kZUp;
  // Y up has x right and z backward, as USD's cameras.
  const GaussianSet set =
      is_z_up ? own : turned(own, level_from(SplatAxes::kYUp).conjugate() * level_from(axes));
  const Eigen::Index count = set.size();
  const int coefficients = sh_coefficients(set.sh_degree);
  std::string out = fmt::format(
      "#usda 1.0\n"
      "(\n"
      "    defaultPrim = \"Splats\"\n"
      "    metersPerUnit = 1\n"
      "    upAxis = \"{}\"\n"
      ")\n\n"
      "def ParticleField3DGaussianSplat \"Splats\" (\n"
      "    prepend apiSchemas = [\"ColorSpaceAPI\"]\n"
      ")\n"
      "{{\n"
      "    uniform token colorSpace:name = \"srgb_rec709_scene\"\n"
      "    uniform token projectionModeHint = \"perspective\"\n"
      "    uniform token sortingModeHint = \"cameraDistance\"\n"
      "    uniform int radiance:sphericalHarmonicsDegree = {}\n",
      is_z_up ? 'Z' : 'Y',
      set.sh_degree);
  const Eigen::Matrix<float, 2, 3> extent = extent_of_splats(set);
  append_array(out, "float3[] extent", 2, 3, [&](Eigen::Index i, int c) { return extent(i, c); });
  out += '\n';
  append_array(out, "point3f[] positions", count, 3, [&](Eigen::Index i, int c) { return set.mean()(i, c); });
  out += '\n';
  append_array(
      out, "quatf[] orientations", count, 4, [&](Eigen::Index i, int c) { return unit_rotation(set, i)[c]; });
  out += '\n';
  append_array(out, "float3[] scales", count, 3, [&](Eigen::Index i, int c) {
    return std::exp(set.log_scale()(i, c));
  });
  out += '\n';
  append_array(out, "float[] opacities", count, 1, [&](Eigen::Index i, int) {
    return opacity_of(set.opacity_logit()(i));
  });
  out += '\n';
  append_array(
      out,
      "float3[] radiance:sphericalHarmonicsCoefficients",
      count * coefficients,
      3,
      [&](Eigen::Index i, int c) { return set.sh(static_cast<int>(i % coefficients))(i / coefficients, c); });
  fmt::format_to(std::back_inserter(out),
                 " (\n        elementSize = {}\n        interpolation = \"vertex\"\n    )\n}}\n",
                 coefficients);
  return out;
}

}  // namespace simuli
