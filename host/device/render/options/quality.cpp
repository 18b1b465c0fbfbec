#include "host/device/render/options/quality.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/device/render/options/validate.hpp"

namespace simuli {

const std::vector<std::string>& quality_names() {
  static const std::vector<std::string> kNames{"draft", "balanced", "exact", "reference"};
  return kNames;
}

std::optional<Quality> find_quality(std::string_view name) {
  const auto& names = quality_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Quality>(found - names.begin());
}

RenderOptions options_of(Quality quality) {
  RenderOptions o;
  switch (quality) {
    case Quality::kDraft:
      o.shutter_iterations = 1;
      o.sh_degree = 0;
      o.sh_storage = ShStorage::kHalf;
      o.alpha_cut = 1.0 / 64.0;
      o.transmittance_cut = 0.02;
      break;
    case Quality::kBalanced:
      break;
    case Quality::kExact:
      o.order = Order::kPerRay;
      o.alpha_cut = 1e-4;
      o.transmittance_cut = 1e-5;
      break;
    case Quality::kReference:
      o.precision = Precision::kDouble;
      o.order = Order::kPerRay;
      o.sh_direction = ShDirection::kRay;
      o.alpha_cut = 1e-5;
      o.transmittance_cut = 1e-8;
      break;
  }
  return o;
}

RenderOptions training_options_of(Quality quality) {
  RenderOptions o = options_of(quality), usual;
  // Nearly always equal to per_ray, at bounded cost.
  if (o.order == Order::kPerRay) o.order = Order::kWindow;
  const Fields own = fields_of(o), defaults = fields_of(usual);
  for (std::size_t i = 0; i < own.all().size(); ++i) {
    const Field& field = own.all()[i];
    if (field.in_training != InTraining::kAny) static_cast<void>(field.set(defaults.all()[i].text()));
  }
  return o;
}

void need_gradients(RenderOptions options, const std::string& where) {
  RenderOptions usual;
  const Fields own = fields_of(options), defaults = fields_of(usual);
  for (std::size_t i = 0; i < own.all().size(); ++i) {
    const Field& field = own.all()[i];
    const std::string found = field.text(), allowed = defaults.all()[i].text();
    if (field.in_training != InTraining::kNoGradients || found == allowed) continue;
    throw Error(
        ErrorKind::kUsage,
        fmt::format(
            "{}: {}: found {}, allowed {}: nothing else has gradients", where, field.key, found, allowed));
  }
}

Quality quality_of_name(const std::string& name) {
  if (name.empty()) return Quality::kBalanced;
  if (const std::optional<Quality> found = find_quality(name)) return *found;
  throw Error(ErrorKind::kUsage,
              fmt::format("quality: found \"{}\", allowed {}", name, fmt::join(quality_names(), ", ")));
}

RenderOptions render_options(const std::string& quality, const std::vector<std::string>& settings) {
  RenderOptions options = options_of(quality_of_name(quality));
  fields_of(options).apply(settings, "settings");
  validate(options);
  return options;
}

}  // namespace simuli
