#pragma once
#include <filesystem>
#include <memory>

namespace simuli {

/// Throws the Error{kInput} with which write_scene() would refuse the folder.
void need_scene_output(const std::filesystem::path& folder);

class OutputLock;

/// Reserves a scene's folder before a training: only this process writes it until destruction. Throws
/// Error{kInput} if the name exists (with `overwrite`: unless it is a scene), if another process has reserved
/// it, and if nothing can be written.
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
