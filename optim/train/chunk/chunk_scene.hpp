#pragma once
// What the chunks of a drive come to: each its own part of one scene.
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

/// A chunk when it has been trained: all that its cameras see, of the LiDARs' particles those that stand
/// nearest to its own part of the path, and the actors that it saw, with what it learned of its LiDARs.
struct ChunkScene {
  Scene scene;
  std::vector<LogLidar> lidars;
  TrainReport report;
};

/// How a scene is parted among chunks: what they must have alike.
struct ChunkSplit {
  const DrivenPath& path;
  const std::vector<DriveChunk>& chunks;
  double overlap_m = 0.0;
};

/// Without the background's particles of the LiDAR set that another chunk than number `index` owns.
[[nodiscard]] Scene owned(Scene scene, const ChunkSplit& parting, std::size_t index);

/// A chunk by its number, whole: good until the next one is asked for.
using ChunkReader = std::function<const ChunkScene&(std::size_t)>;

/// The mean of the LiDARs' drop functions, each chunk's by the sweeps that taught it.
class MeanRayDrop {
 public:
  void add(const ChunkScene& part);
  /// By the LiDARs' names.
  [[nodiscard]] std::vector<RayDrop> mean() const;

 private:
  struct Sum {
    RayDrop::Parameters parameters{};
    double weight = 0.0;
  };
  std::map<std::string, Sum> sums_;
};

/// One scene of all `count` of them, in their order, each of which is read twice; nothing but the scene and
/// one of them is in memory at a time. All that they have of the background: of the camera set each has its
/// own, which is seen from its part of the path alone (Scene::visibility_sets) together with what stood behind actors;
/// of an actor the particles of the chunk that has most of it, each key pose as the chunk found it in
/// which it lies, moved by what both have in common; the environment's mean, and that of the LiDARs' drop
/// functions. `actors`: all that may have particles, their names those of the chunks' actors.
[[nodiscard]] Scene merged(std::size_t count,
                           const ChunkReader& part,
                           const std::vector<Actor>& actors,
                           const ChunkSplit& parting);

/// Adds what a chunk says of itself to what is told of all; `share` of its iterations in theirs weighs its
/// means.
void add_chunk(TrainReport& all, const TrainReport& own, double share);

}  // namespace simuli
