#pragma once
// What the stretches of a drive come to: each its own part of one scene.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "io/log/log.hpp"
#include "optim/report/train_report.hpp"
#include "optim/stretch/stretches.hpp"

namespace simuli {

/// A stretch when it has been trained: all that its cameras see, of the LiDARs' particles those that stand
/// nearest to its own part of the path, and the actors that it saw, with what it learned of its LiDARs.
struct StretchScene {
  Scene scene;
  std::vector<LogLidar> lidars;
  TrainReport report;
};

/// How a scene is parted among stretches: what they must have alike.
struct StretchParting {
  const DrivenPath& path;
  const std::vector<Stretch>& stretches;
  double overlap_m = 0.0;
};

/// Without the background's particles of the LiDAR set that another stretch than number `index` owns.
[[nodiscard]] Scene owned(Scene scene, const StretchParting& parting, std::size_t index);

/// A stretch by its number, whole: good until the next one is asked for.
using StretchReader = std::function<const StretchScene&(std::size_t)>;

/// The mean of the LiDARs' drop functions, each stretch's by the sweeps that taught it.
class MeanRayDrop {
 public:
  void add(const StretchScene& part);
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
/// own, which is seen from its part of the path alone (Scene::vistas) together with what stood behind actors;
/// of an actor the particles of the stretch that has most of it, each key pose as the stretch found it in
/// which it lies, moved by what both have in common; the environment's mean, and that of the LiDARs' drop
/// functions. `actors`: all that may have particles, their names those of the stretches' actors.
[[nodiscard]] Scene merged(std::size_t count,
                           const StretchReader& part,
                           const std::vector<Actor>& actors,
                           const StretchParting& parting);

/// Adds what a stretch says of itself to what is told of all; `share` of its iterations in theirs weighs its
/// means.
void add_stretch(TrainReport& all, const TrainReport& own, double share);

}  // namespace simuli
