#pragma once
// How training changes what particles there are and what holds them in place.
#include <cstddef>

#include "host/base/allowed.hpp"

namespace simuli {

/// The paper's L_anchor: camera particles stay near the LiDAR set's surfaces (METHOD section 10). Off: the
/// paper's 0.01 changes pictures by 0.02 dB either way, on and off the path.
struct AnchorOptions {
  double weight = 0.0;
};
template <class F>
constexpr void visit_fields(AnchorOptions& o, F&& field) {
  field("anchor.weight",
        o.weight,
        at_least(0.0),
        "of camera particles' mean distance (m) to the LiDAR set, 0.01 in the paper; 0: none");
}

/// Relocation and growth by reconstruction error (METHOD section 11).
struct DensifyOptions {
  int every = 50;
  int first = 100;
  double last_share = 0.8;
  bool lidar = false;  // its particles start where returns are; there are enough of them
  double growth = 0.1;
  double most = 2.0;
  std::size_t cap = 4'000'000;
  double noise = 500.0;
};
template <class F>
constexpr void visit_fields(DensifyOptions& o, F&& field) {
  field("densify.every",
        o.every,
        at_least(0),
        "iterations from one relocation and growth by error to the next; 0: never");
  field("densify.first", o.first, at_least(1), "iteration of the first");
  field("densify.last_share", o.last_share, range(0.0, 1.0), "of the iterations: none after that");
  field("densify.lidar", o.lidar, "also the LiDAR set");
  field("densify.growth", o.growth, range(0.0, 1.0), "of a set's particles, per time");
  field("densify.most", o.most, at_least(1.0), "particles of a set over those at the start, at most");
  field("densify.cap", o.cap, at_least(0), "particles of both sets together, at most");
  field("densify.noise", o.noise, at_least(0.0), "m^-2, of positions' jitter per m of their learning rate");
}

/// LiDAR particles that no training sweep needs are taken out (METHOD section 11).
struct PruneOptions {
  double weight = 0.12;
  int first = 100;
  int times = 2;
  double last_share = 0.5;
  bool row_ranges = true;
};
template <class F>
constexpr void visit_fields(PruneOptions& o, F&& field) {
  field("prune.weight",
        o.weight,
        range(0.0, 1.0),
        "LiDAR particles whose weight in no ray of any training sweep reaches this are taken out; 0: none");
  field("prune.first", o.first, at_least(0), "iteration before which none is: opacities must settle");
  field("prune.times", o.times, at_least(1), "how often, evenly spread");
  field("prune.last_share", o.last_share, range(0.0, 1.0), "of the iterations: the last time");
  field("prune.row_ranges",
        o.row_ranges,
        "each time the LiDARs' range biases by row take up what rows state beside what the set shows");
}

}  // namespace simuli
