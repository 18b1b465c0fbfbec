#pragma once
// A scene folder: camera.ply, lidar.ply (io/splat/ply.hpp), what its pictures have beside particles
// (io/scene/appearance_file.hpp) and keeps of the frames it was made of (io/scene/support_file.hpp), and
// scene.json, which names their counts.
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

/// A scene with the sensors and the trajectory it was trained on, so that it renders without its log.
struct SceneFile {
  Scene scene;
  std::vector<LogCamera> cameras;
  std::vector<LogLidar> lidars;
  Trajectory world_from_rig;  // may be empty
  /// When the frames were recorded that it was made of, by sensor; none of a version that didn't say.
  FrameSpans recorded_frames = {};
  SplatReport splats = {};  // of a file of splats
  /// How the scene was made; nothing of a scene that wasn't trained, or by a version that didn't say.
  std::optional<TrainingRecord> training = {};
  /// What it keeps of those frames, to tell how well it knows what it shows; null of a scene that doesn't.
  std::shared_ptr<const SupportRecord> support = {};

  /// The sensor of that name; null when there is none.
  [[nodiscard]] const LogCamera* find_camera(const std::string& name) const;
  [[nodiscard]] const LogLidar* find_lidar(const std::string& name) const;
};

/// Tells the scene's colour grids where their frames look, if the file knows all their cameras and its path goes on
/// for as long as they do.
void aim_color_grids(SceneFile& file);

/// Reads a scene folder, or a file of splats (scene_of_splats()). Unknown keys are errors, as are counts or
/// SH degrees other than scene.json says. Errors as in io/log/log.hpp.
[[nodiscard]] SceneFile read_scene(const std::filesystem::path& folder);
/// Writes the folder beside its place and puts it there in one step, in the place of an older scene: whatever
/// happens meanwhile, one of the two is there and whole. Error{kInput} for what could not be read back, and
/// for a folder with anything but a scene in it.
void write_scene(const std::filesystem::path& folder, const SceneFile& scene);
/// Writes scene.json anew, in one step, of a folder that write_scene() has written and whose particles are the
/// same.
void rewrite_scene_json(const std::filesystem::path& folder, const SceneFile& scene);

}  // namespace simuli
