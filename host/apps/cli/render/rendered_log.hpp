#pragma once
// Rendered frames as a log for `train` and `eval`.
#include <filesystem>
#include <string>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/frame.hpp"
#include "io/log/log.hpp"

namespace simuli::cli {

/// Writes a drive through a scene as a log. Actors have the poses of the scene, including corrections learned
/// in training.
class RenderedLog {
 public:
  /// The sensors must have unique names. Creates images/ and sweeps/ in the existing folder.
  RenderedLog(const std::filesystem::path& folder,
              const Scene& scene,
              const Trajectory& world_from_rig,
              const std::vector<Sensor>& sensors);

  /// Writes the picture ("png", "exr") or sweep of frame `number` of the sensor.
  void add(const Frame& frame, std::size_t number, const std::string& images);
  /// Writes log.json.
  void finish();

 private:
  Log log_;
};

}  // namespace simuli::cli
