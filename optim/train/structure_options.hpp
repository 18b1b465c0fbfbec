#pragma once
// Options for changes of the particle sets during training.
#include <cstddef>

#include "host/core/base/allowed.hpp"

namespace simuli {

/// Relocation and growth by reconstruction error (METHOD section 11).
struct DensifyOptions {
  static constexpr double kLastShare = 0.8;  // of the iterations; later particles would not converge
  /// Uses of each training picture between densifications; half of them accumulate errors.
  double epochs = 0.5;
  /// Also densify the LiDAR set, whose particles start at returns (docs/DECISIONS.md, "Growth").
  bool lidar = false;
  /// Relative growth of a set per densification (docs/DECISIONS.md, "Growth").
  double growth = 0.1;
  double most = 2.0;
  std::size_t cap = 4'000'000;
  /// Amplitude of position jitter, m^-2 per m of learning rate (docs/DECISIONS.md, "Growth").
  double noise = 500.0;
};
template <class F>
constexpr void visit_fields(DensifyOptions& o, F&& field) {
  field.group("Camera set");
  field("densify.epochs",
        o.epochs,
        at_least(0.0),
        "Uses of each training picture between densifications in regions of high error. Fewer: sharper "
        "short trainings, slower; 0: no densification, faster.");
  field("densify.most",
        o.most,
        at_least(1.0),
        "Maximum number of particles relative to the initial number. More: sharper pictures, slower.");
  field.internal(o.lidar);
  field.internal(o.growth);
  field.internal(o.noise);
  field.group("Memory");
  field("densify.cap",
        o.cap,
        at_least(0),
        "Maximum number of particles of both sets together. Lower it to "
        "save memory.");
}

/// Pruning of LiDAR particles that contribute to no training sweep (METHOD section 11).
struct PruneOptions {
  double weight = 0.12;
  int first = 100;  // first iteration: opacities must have converged
  int times = 2;    // number of prunings, evenly spaced
  double last_share =
      0.5;  // share of the iterations at the last pruning; the remaining particles adapt afterwards
  /// With each pruning update the LiDARs' range biases by row from the difference between recorded and rendered
  /// ranges (docs/DECISIONS.md, "LiDAR set").
  bool row_ranges = true;
};
template <class F>
constexpr void visit_fields(PruneOptions& o, F&& field) {
  field.group("LiDAR set");
  field("prune.weight",
        o.weight,
        range(0.0, 1.0),
        "Blending weight below which in every ray of the sweeps a LiDAR particle is pruned. More: fewer "
        "particles, faster; 0: none are pruned.");
  field.internal(o.first);
  field.internal(o.times);
  field.internal(o.last_share);
  field.internal(o.row_ranges);
}

}  // namespace simuli
