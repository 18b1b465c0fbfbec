#pragma once
#include <filesystem>
#include <memory>

namespace simuli {

/// What write_scene() would refuse of the folder, before there is a scene: Error{kInput}.
void need_scene_output(const std::filesystem::path& folder);

class OutputLock;

/// A scene's folder, taken before a training begins: this process alone makes it until this is destroyed.
/// Error{kInput} when there is something of that name (with `overwrite`: something else than a scene), when
/// another process has it, and where nothing can be written.
class SceneOutput {
 public:
  explicit SceneOutput(const std::filesystem::path& folder, bool overwrite = false);
  SceneOutput(const SceneOutput&) = delete;
  SceneOutput& operator=(const SceneOutput&) = delete;
  ~SceneOutput();

 private:
  std::unique_ptr<OutputLock> lock_;
};

}  // namespace simuli
