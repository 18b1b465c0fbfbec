#pragma once
// Labelled actors with what the labels leave out: actors without one, and the time before and after one.
#include <cstddef>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "optim/actors/find_actors.hpp"

namespace simuli {

struct CompletedActors {
  std::vector<Actor> actors;  // the labelled ones in their order, then the added ones
  std::size_t added = 0;      // found actors that have no label
  std::size_t continued = 0;  // labels with poses before their first or behind their last that were found
};

/// Labels that stand are left out. `found` is told apart by match_actor(): what has no label is added under a
/// name of its own; what has one is the label's, which stays as it is, and where it is seen before the label
/// begins or after it ends, the label goes on there, at the found poses less the common offset of the two
/// (labels end where cameras see an actor no longer, or where whoever labels lost it). Of several labels of one
/// found actor the one next in time goes on.
[[nodiscard]] CompletedActors complete_actors(std::vector<Actor> labelled, const FoundActors& found);

}  // namespace simuli
