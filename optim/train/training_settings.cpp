#include "optim/train/training_settings.hpp"

namespace simuli {

std::vector<std::string> settings_of(const TrainingOptions&) { return {}; }

std::string quality_of(const RenderOptions&) { return "balanced"; }

}  // namespace simuli
