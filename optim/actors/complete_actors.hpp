#pragma once
// Completes labelled actors: unlabelled actors, and times before and after a label.
#include <cstddef>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "optim/actors/find_actors.hpp"

namespace simuli {

struct CompletedActors {
  std::vector<Actor> actors;  // the labelled actors in order, followed by the added ones
  std::size_t added = 0;  // found actors without label
  std::size_t continued = 0;  // labels extended by found poses before their start or after their end
};

/// Removes labels of static objects. Matches `found` with labels by match_actor(): actors without label are
/// added under a new name; where a found actor is seen before its label begins or after it ends, the label is
/// extended by the found poses minus the offset common to both (labels end where cameras no longer see an
/// actor, or where labellers lost it). Of several labels of one found actor the nearest in time is extended.
/// Labelled poses do not change.
[[nodiscard]] CompletedActors complete_actors(std::vector<Actor> labelled, const FoundActors& found);

}  // namespace simuli
