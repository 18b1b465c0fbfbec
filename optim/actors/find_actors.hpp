#pragma once
// Finds moving objects of a log without boxes, from LiDAR alone.
#include <string>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/actors/finding_options.hpp"

namespace simuli {

struct FoundActors {
  std::vector<Actor> actors;  // sorted by first observation
  /// Names of labels of static objects that the log claims to move: hardly any return in them moved, and sweeps
  /// see through their claimed later positions.
  std::vector<std::string> standing;
  FindReport report;
};

/// Finds rigid moving bodies: clusters of returns that other sweeps see through are tracked from sweep to
/// sweep, registered to one surface, and tracked while they stand. Each has a box of all parts that move with
/// it, on the ground, x along the driving direction, and a key pose for every training sweep that sees it;
/// tracks extend over held-out frames at their ends. Rejects bodies that may be static: that travel less than
/// options.min_travel_m, are seen by fewer than options.min_sweeps sweeps, or are seen through along their
/// track. Reads only the training sweeps of the finest LiDAR with rows; the same log and options give the same
/// bits. Throws Error{kInput} when a sweep cannot be read.
[[nodiscard]] FoundActors find_actors(const Log& log,
                                      const FrameSelection& frames,
                                      const ActorFinding& options);

}  // namespace simuli
