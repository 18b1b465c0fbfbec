#pragma once
// What the search for moving things is told, and what it says of itself.
#include <cstddef>

#include "host/core/base/allowed.hpp"

namespace simuli {

/// m, least way of what is found: a shorter one is no evidence beside labels, tracks and edges of shadows that
/// are off by as much. Not measured.
inline constexpr double kLeastFoundTravel_m = 2.0;

struct ActorFinding {
  int min_sweeps = 8;
};

/// The keys that users set, with what is allowed and what it means (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(ActorFinding& o, F&& field) {
  field("actors.min_sweeps",
        o.min_sweeps,
        range(4, 1000),
        "Sweeps that must see what is found. Lower it for short logs; higher: fewer false finds.");
}

/// What the search did.
struct FindReport {
  std::size_t sweeps = 0;          // searched
  std::size_t moving_returns = 0;  // at places that other sweeps look through, of those above the ground
  std::size_t chains = 0;          // of clusters that move from sweep to sweep
  std::size_t actors = 0;          // found; of a drive that is cut, in each of its chunks
  std::size_t added = 0;           // of them, without a label
  std::size_t continued = 0;       // labels that go on where they had ended (complete_actors.hpp)
  std::size_t returns_on_actors = 0;
  std::size_t moving_on_actors = 0;  // of moving_returns
  double seconds = 0.0;

  FindReport& operator+=(const FindReport& other) {
    sweeps += other.sweeps;
    moving_returns += other.moving_returns;
    chains += other.chains;
    actors += other.actors;
    added += other.added;
    continued += other.continued;
    returns_on_actors += other.returns_on_actors;
    moving_on_actors += other.moving_on_actors;
    seconds += other.seconds;
    return *this;
  }
};

}  // namespace simuli
