#include "host/device/render/options/render_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/device/render/options/validate.hpp"

namespace simuli {

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
