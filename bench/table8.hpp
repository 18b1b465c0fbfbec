#pragma once
#include <string>
#include <vector>

#include "bench/fit.hpp"
#include "bench/measure.hpp"

namespace simuli::bench {

struct Table8Options {
  std::string log;       // folder of a log with sweeps; empty: the embedded street
  int iterations = 120;  // of each training, one sweep each
  double voxel_m = 0.2;  // one particle per voxel
  double coarse_voxel_m = 1.0;
};

/// Table 8 of the paper: the three projections, and exact extents beside them, each trained and then compared
/// with held-out sweeps.
///   table8/<monte_carlo|unscented|linearized|exact>/<metric>   trained and rendered with that projection
///   table8_again/seed_<2|3>/<metric>                           unscented, the sweeps in another order: noise
///   table8_render/<projection>/<metric>                        trained with unscented, rendered with that
///   table8_coarse/... and the same again                       with few large particles
///   table8_clipped/...                                         of single long particles (bench/clipped.hpp)
/// Metrics: medl2_m2, mean_rel_l2, intensity_rmse, raydrop_accuracy, chamfer_m2 (METHOD section 13);
/// worst_difference of the five from those of monte_carlo (table8_again: of the first seed), in %; clipped:
/// the share of the light of held-out sweeps that the boxes cut off, in %; the projection's device time per
/// sweep.
[[nodiscard]] std::vector<Row> run_table8(const std::string& device_request,
                                          const Table8Options& options,
                                          const Note& note);

}  // namespace simuli::bench
