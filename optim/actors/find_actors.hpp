#pragma once
// Moving things of a log that has no boxes, found from its LiDAR alone.
#include <string>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/actors/finding_options.hpp"

namespace simuli {

struct FoundActors {
  std::vector<Actor> actors;  // by the time they are first seen
  /// Names of the log's labels that drive through what stands: hardly anything in them moved, and where they say
  /// that it went sweeps look through it.
  std::vector<std::string> standing;
  FindReport report;
};

/// Rigid bodies that drive: clusters of returns which other sweeps look through are followed from sweep to
/// sweep, registered onto one surface, and followed on while they stand. Each has a box of all that moves
/// with it, on the ground, x where it drives to, and a key pose for every training sweep that sees it; tracks
/// reach over held-out frames at their ends. Nothing that may stand is taken: what travels less than
/// options.min_travel_m, is seen by fewer than options.min_sweeps sweeps, or whose surface is looked through
/// where the track has it, is none. Only the training sweeps of the finest LiDAR with rows are read; the same
/// log and options give the same bits. Error{kInput} when a sweep can't be read.
[[nodiscard]] FoundActors find_actors(const Log& log,
                                      const FrameSelection& frames,
                                      const ActorFinding& options);

}  // namespace simuli
