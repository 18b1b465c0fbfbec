#include "io/scene/scene_output.hpp"

#include "io/base/output.hpp"

namespace simuli {

SceneOutput::SceneOutput(const std::filesystem::path& folder, bool overwrite)
    : lock_(std::make_unique<OutputLock>(folder)) {
  if (!overwrite) need_new_path(folder);
  need_scene_output(folder);
}

SceneOutput::~SceneOutput() = default;

}  // namespace simuli
