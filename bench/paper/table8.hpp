#pragma once
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct Table8Options {
  std::string log;       // with sweeps, as open_drive() takes it; empty: the embedded street
  int iterations = 120;  // of each training, one sweep each
  double voxel_m = 0.2;  // one particle per voxel
  double coarse_voxel_m = 1.0;
  int seeds = 5;  // trainings of each column, the sweeps in another order each time
};

/// Table 8 of the paper: the three projections, and exact extents beside them, each trained and then compared
/// with held-out sweeps.
///   table8/<monte_carlo|unscented|linearized|exact>/<metric>   trained and rendered with that projection
///   table8_render/<projection>/<metric>                        trained with unscented, rendered with that
///   table8_coarse/... and the same again                       with few large particles
///   table8_clipped/...                                         of single long particles
///   (bench/paper/clipped.hpp)
/// Metrics: medl2_m2, mean_rel_l2, intensity_rmse, raydrop_accuracy, raydrop_trivial, drop_recall,
/// drop_precision, chamfer_m2 (METHOD section 13), the middle of all seeds, give or take half of their range
/// (as are all spreads here but that of a time). Beside each
///   <metric>_from_monte_carlo   difference from monte_carlo with the same seed, %
///   <metric>_seeds              of monte_carlo itself: half of the range of its seeds, % of their middle
/// Of the first seed: clipped, the share of the light of held-out sweeps that the boxes cut off, in %, and
/// projection_ms, the projection's device time per sweep.
[[nodiscard]] std::vector<Row> run_table8(const std::string& device_request,
                                          const Table8Options& options,
                                          const Note& note);

}  // namespace simuli::bench
