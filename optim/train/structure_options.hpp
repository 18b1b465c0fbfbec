#pragma once
// How training changes what particles there are and what holds them in place.
#include <cstddef>

namespace simuli {

/// L_anchor: camera particles stay near the LiDAR set's surfaces (METHOD section 10).
struct AnchorOptions {
  double weight = 0.01;   // of the mean distance in m; 0: none
  int neighbours = 50;    // K, candidates of each particle
  int every = 1000;       // iterations from one search for candidates to the next
  int choose_every = 10;  // iterations from one choice of the nearest candidate to the next
  double reach_m = 2.0;   // particles that far from any LiDAR particle (sky, beyond reach) go free
};

/// Relocation and growth by reconstruction error (METHOD section 11).
struct DensifyOptions {
  int every = 0;                // iterations, 100 for instance; 0: never
  int first = 100;              // iteration of the first
  double last_share = 0.8;      // of the iterations: none after that
  double growth = 0.05;         // of each set, per time
  std::size_t cap = 4'000'000;  // particles of both sets together
  double noise = 500.0;         // m^-2, of jitter per m of the means' learning rate
};

/// Learning of where sensors sit on the rig: one offset for all frames of a sensor. Rates fall as the means'
/// do.
struct PoseOptions {
  bool camera = false;
  bool lidar = false;
  double translation_m = 1e-3;  // per step of Adam, at the start
  double rotation_rad = 1e-4;
};

}  // namespace simuli
