#include "optim/train/training_settings.hpp"

#include "host/base/fields.hpp"
#include "host/render/options/render_settings.hpp"

namespace simuli {

TrainingOptions training_options(const std::string& quality, const std::vector<std::string>& settings) {
  TrainingOptions options;
  options.train.render = training_options_of(quality_of_name(quality));
  fields_of(options).apply(settings, "settings");
  return checked(options);
}

}  // namespace simuli
