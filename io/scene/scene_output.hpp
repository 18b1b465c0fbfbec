#pragma once
#include <filesystem>

namespace simuli {

/// What write_scene() would refuse of the folder, before there is a scene: Error{kInput}.
void need_scene_output(const std::filesystem::path& folder);

}  // namespace simuli
