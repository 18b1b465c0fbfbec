#pragma once
// Merging the trained chunks of a drive into one scene.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "io/log/log.hpp"
#include "optim/train/train_report.hpp"
#include "optim/train/chunk/chunks.hpp"

namespace simuli {

/// A trained chunk: all its camera particles, the LiDAR particles nearest to its part of the path, its actors,
/// and the sensor parameters learned from its sweeps.
struct ChunkScene {
  Scene scene;
  std::vector<LogLidar> lidars;
  TrainReport report;
};

/// The division of a scene among chunks, common to all of them.
struct ChunkSplit {
  const DrivenPath& path;
  const std::vector<DriveChunk>& chunks;
  double overlap_m = 0.0;
};

/// Returns the scene without background LiDAR particles owned by chunks other than `index`.
[[nodiscard]] Scene owned(Scene scene, const ChunkSplit& parting, std::size_t index);

/// Returns a chunk by its index; the reference is valid until the next call.
using ChunkReader = std::function<const ChunkScene&(std::size_t)>;

/// The mean of the LiDARs' ray-drop functions over chunks, weighted by the sweeps that trained each.
class MeanRayDrop {
 public:
  void add(const ChunkScene& part);
  /// Returns the mean functions by LiDAR name.
  [[nodiscard]] std::vector<RayDrop> mean() const;

 private:
  struct Sum {
    RayDrop::Parameters parameters{};
    double weight = 0.0;
  };
  std::map<std::string, Sum> sums_;
};

/// Merges `count` chunks into one scene. Each is read twice; memory holds the scene and one chunk at a time.
/// Background: each chunk keeps its camera set, rendered only from its part of the path
/// (Scene::visibility_sets), with its disoccluded sets. Actors: the particles of the chunk that has most of
/// them; each key pose comes from the chunk in whose part of the path it lies, moved by the relative pose of
/// both. Environment and ray-drop functions are means. `actors`: all actors that may own particles, with the
/// names used by the chunks.
[[nodiscard]] Scene merged(std::size_t count,
                           const ChunkReader& part,
                           const std::vector<Actor>& actors,
                           const ChunkSplit& parting);

/// Adds a chunk's report to the total; `share`, the chunk's part of all iterations, weights its means.
void add_chunk(TrainReport& all, const TrainReport& own, double share);

}  // namespace simuli
