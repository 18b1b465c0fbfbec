#pragma once
// Rendered frames as a log: what `train` and `eval` read.
#include <filesystem>
#include <string>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/frame.hpp"
#include "io/log/log.hpp"

namespace simuli::cli {

/// A drive through a scene as its sensors recorded it. Actors are where the scene has them, what training
/// learned of their tracks included.
class RenderedLog {
 public:
  /// Of sensors with names of their own. Makes images/ and sweeps/ in the folder, which is there.
  RenderedLog(const std::filesystem::path& folder,
              const Scene& scene,
              const Trajectory& world_from_rig,
              const std::vector<Sensor>& sensors);

  /// Writes the picture ("png", "exr") or sweep of the sensor's frame of that number.
  void add(const Frame& frame, std::size_t number, const std::string& images);
  /// Writes log.json.
  void finish();

 private:
  Log log_;
};

}  // namespace simuli::cli
