#pragma once
// How training changes what particles there are and what holds them in place.
#include <cstddef>

#include "host/core/base/allowed.hpp"

namespace simuli {

/// The paper's L_anchor: camera particles stay near the LiDAR set's surfaces (METHOD section 10). Off: the
/// paper's 0.01 changes pictures by 0.02 dB either way, on and off the path.
struct AnchorOptions {
  double weight = 0.0;
};
template <class F>
constexpr void visit_fields(AnchorOptions& o, F&& field) {
  field.group("Camera set");
  field("anchor.weight",
        o.weight,
        at_least(0.0),
        "Weight of camera particles' distance in m to the nearest LiDAR particle. 0.01: the paper's "
        "anchoring, slower and no better; 0: off.");
}

/// Relocation and growth by reconstruction error (METHOD section 11).
struct DensifyOptions {
  static constexpr double kLastShare = 0.8;  // of the iterations: what comes last has time to settle, too
  /// Looks at each training picture from one time to the next: half of them tell what errs.
  double epochs = 0.5;
  /// Also the LiDAR set. Its particles start where returns are: 3.95 cm for 3.94 on drive 0013, 3 % fewer.
  bool lidar = false;
  /// Of a set's particles, per time. Drive 0052: 0.2, with most = 3, 26.29 dB for 26.17 with 171 k particles
  /// for 132 k.
  double growth = 0.1;
  double most = 2.0;
  std::size_t cap = 4'000'000;
  /// m^-2, of positions' jitter per m of their learning rate. Street: 0 33.37 dB for 33.38, 3 m beside the path
  /// 19.8 for 20.0.
  double noise = 500.0;
};
template <class F>
constexpr void visit_fields(DensifyOptions& o, F&& field) {
  field.group("Camera set");
  field("densify.epochs",
        o.epochs,
        at_least(0.0),
        "Looks at each training picture between additions of particles where they err most. Fewer: "
        "sharper short trainings, slower; 0: none are added, faster.");
  field("densify.most",
        o.most,
        at_least(1.0),
        "Most particles over those at the start. More: sharper pictures, slower.");
  field.internal(o.lidar);
  field.internal(o.growth);
  field.internal(o.noise);
  field.group("Memory");
  field("densify.cap", o.cap, at_least(0), "Most particles of both sets together. Lower it to save memory.");
}

/// LiDAR particles that no training sweep needs are taken out (METHOD section 11).
struct PruneOptions {
  double weight = 0.12;
  int first = 100;          // iteration: opacities must settle
  int times = 2;            // evenly spread
  double last_share = 0.5;  // of the iterations, the last time: what is left learns to do without the others
  /// Each time the LiDARs' range biases by row take up what rows state beside what the set shows. Drive 0013:
  /// 3.94 cm without, 3.79 with; 0052: 2.02 and 1.83 cm.
  bool row_ranges = true;
};
template <class F>
constexpr void visit_fields(PruneOptions& o, F&& field) {
  field.group("LiDAR set");
  field("prune.weight",
        o.weight,
        range(0.0, 1.0),
        "Weight that a LiDAR particle must have in some ray of a sweep to stay. More: fewer particles, "
        "faster; 0: all stay.");
  field.internal(o.first);
  field.internal(o.times);
  field.internal(o.last_share);
  field.internal(o.row_ranges);
}

}  // namespace simuli
