#include "optim/train/training_settings.hpp"

#include "host/base/fields.hpp"
#include "host/render/options/render_settings.hpp"

namespace simuli {

std::vector<std::string> settings_of(const TrainingOptions& options) { return lines_of(options); }

std::string quality_of(const RenderOptions& options) {
  const std::vector<std::string> lines = lines_of(options);
  for (const Quality quality : {Quality::kBalanced, Quality::kDraft, Quality::kExact, Quality::kReference}) {
    if (lines_of(training_options_of(quality)) == lines) {
      return quality_names()[static_cast<std::size_t>(quality)];
    }
  }
  return "custom";
}

TrainingOptions training_options(const std::string& quality, const std::vector<std::string>& settings) {
  TrainingOptions options;
  options.train.render = training_options_of(quality_of_name(quality));
  fields_of(options).apply(settings, "settings");
  return checked(options);
}

}  // namespace simuli
