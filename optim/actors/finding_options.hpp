#pragma once
// Options and report of the search for moving objects.
#include <cstddef>

#include "host/core/base/allowed.hpp"

namespace simuli {

/// Shortest path of a found object in m: shorter ones are within the errors of labels, tracks and shadow edges.
inline constexpr double kLeastFoundTravel_m = 2.0;

struct ActorFinding {
  int min_sweeps = 8;
};

/// The setting keys with allowed values and help (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(ActorFinding& o, F&& field) {
  field("actors.min_sweeps",
        o.min_sweeps,
        range(4, 1000),
        "Sweeps that must see what is found. Lower it for short logs; higher: fewer false finds.");
}

/// Counts of the search.
struct FindReport {
  std::size_t sweeps = 0;          // searched
  std::size_t moving_returns = 0;  // returns above the ground at positions that other sweeps see through
  std::size_t chains = 0;  // chains of clusters that move from sweep to sweep
  std::size_t actors = 0;  // found; for a drive in chunks summed over chunks
  std::size_t added = 0;  // of these, without label
  std::size_t continued = 0;  // labels extended in time (complete_actors.hpp)
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
