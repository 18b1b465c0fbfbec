#include "host/render/options/quality.hpp"

#include <algorithm>

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
  constexpr RenderOptions kDefault;
  RenderOptions o = options_of(quality);
  o.precision = kDefault.precision;
  // Almost always the same as per_ray, and never much dearer.
  if (o.order == Order::kPerRay) o.order = Order::kWindow;
  o.sh_direction = kDefault.sh_direction;
  o.sh_degree = kDefault.sh_degree;
  o.sh_storage = kDefault.sh_storage;
  o.detail = 0.0;
  return o;
}

bool has_gradients(const RenderOptions& options) {
  return options.sh_direction == ShDirection::kParticle && options.sh_degree == 3 &&
         options.sh_storage == ShStorage::kFull && options.detail == 0.0;
}

}  // namespace simuli
