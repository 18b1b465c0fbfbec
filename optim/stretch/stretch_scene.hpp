#pragma once
// What the stretches of a drive come to: each its own part of one scene.
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"
#include "io/log/log.hpp"
#include "optim/report/train_report.hpp"
#include "optim/stretch/stretches.hpp"

namespace simuli {

/// A stretch when it has been trained: the particles that stand nearest to its own part of the path, its far
/// shell, and the actors that it saw, with what it learned of its LiDARs.
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
  double shell_distance_m = 0.0;  // from the scene's origin; particles that far are the far shell's
  double shell_spacing_deg = 0.0;
};

/// Without the background's particles that another stretch than number `index` owns. The far shell and all of
/// the actors' stay.
[[nodiscard]] Scene owned(Scene scene, const StretchParting& parting, std::size_t index);

/// One scene of all of them, in their order. Of each cell of the far shell the first stretch's particles that
/// has any; of an actor the particles of the stretch that has most of it, each key pose as the stretch found
/// it in which it lies, moved by what both have in common; the environment's mean; the LiDARs' drop functions
/// of the first. `actors`: all that may have particles, their names those of the stretches' actors.
[[nodiscard]] Scene merged(std::vector<StretchScene> parts,
                           const std::vector<Actor>& actors,
                           const StretchParting& parting);

/// Adds what a stretch says of itself to what is told of all; `share` of its iterations in theirs weighs its
/// means.
void add_stretch(TrainReport& all, const TrainReport& own, double share);

/// What the settings of a training say of a stretch, behind those of a training in one piece; and of the one
/// whose state a checkpoint holds, empty where that is no stretch's. Error{kInput} for what is no checkpoint.
[[nodiscard]] std::string stretch_lines(int iterations, std::size_t index, std::size_t count);
[[nodiscard]] std::string stretch_lines(const std::filesystem::path& checkpoint);
/// Where a training that is stored in `checkpoint` keeps its stretch number `index` when that is done.
[[nodiscard]] std::filesystem::path stretch_file(const std::filesystem::path& checkpoint, std::size_t index);
/// Keeps a part in a file, by the text that tells which training's it is. Atomic.
void write_stretch(const std::filesystem::path& file, const std::string& settings, const StretchScene& part);
/// The part again, the same bits; `log` has the actors and LiDARs that it was trained on. Error{kInput} for
/// what is no such file, or of another training.
[[nodiscard]] StretchScene read_stretch(const std::filesystem::path& file,
                                        const std::string& settings,
                                        const Log& log);

}  // namespace simuli
