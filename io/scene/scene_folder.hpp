#pragma once
// Scene folders: camera.ply, lidar.ply (io/splat/ply.hpp), pictures of the appearance
// (io/scene/scene_parts.hpp), the support record (io/scene/scene_parts.hpp), and scene.json.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "io/log/frame_spans.hpp"
#include "io/log/log.hpp"
#include "io/scene/training_record.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {

struct SupportRecord;  // host/core/record/support_record.hpp

/// A scene with the sensors and the trajectory of its training, so that it can be rendered without its log.
struct SceneFile {
  Scene scene;
  std::vector<LogCamera> cameras;
  std::vector<LogLidar> lidars;
  Trajectory world_from_rig;  // may be empty
  /// Times of the recorded training frames by sensor; empty for scenes of older versions.
  FrameSpans recorded_frames = {};
  SplatReport splats = {};  // of a splat file
  /// How the scene was made; no value for untrained scenes and scenes of older versions.
  std::optional<TrainingRecord> training = {};
  /// Record of the training frames for support; null if the scene has none.
  std::shared_ptr<const SupportRecord> support = {};

  /// Returns the sensor of that name; null if there is none.
  [[nodiscard]] const LogCamera* find_camera(const std::string& name) const;
  [[nodiscard]] const LogLidar* find_lidar(const std::string& name) const;
};

/// Sets the view directions of the scene's colour grids if the file contains all their cameras and the
/// trajectory covers their times.
void aim_color_grids(SceneFile& file);

/// Reads a scene folder or a splat file (scene_of_splats()). Unknown keys are errors, as are counts or SH
/// degrees that contradict scene.json. Errors as in io/log/log.hpp.
[[nodiscard]] SceneFile read_scene(const std::filesystem::path& folder);
/// Writes a temporary folder and replaces an older scene in one step; at any time one of them exists
/// completely. Throws Error{kInput} for a scene that could not be read back, and for an existing folder with
/// other files.
void write_scene(const std::filesystem::path& folder, const SceneFile& scene);
/// Rewrites scene.json atomically in a folder of write_scene() with the same particles.
void rewrite_scene_json(const std::filesystem::path& folder, const SceneFile& scene);

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
