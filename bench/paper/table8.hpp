#pragma once
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct Table8Options {
  std::string log;       // with sweeps, in the format of open_drive(); empty: the embedded street
  int iterations = 120;  // per training, one sweep each
  double voxel_m = 0.2;  // one particle per voxel
  double coarse_voxel_m = 1.0;
  int seeds = 5;  // trainings per column with different orders of the sweeps
};

/// Table 8 of the paper: the three projections and exact extents, each trained and compared with held-out
/// sweeps.
///   table8/<monte_carlo|unscented|linearized|exact>/<metric>   trained and rendered with this projection
///   table8_render/<projection>/<metric>                        trained with unscented, rendered with this
/// projection
///   table8_coarse/...                                          the same with few large particles
///   table8_clipped/...                                         single long particles
/// (bench/paper/clipped.hpp)
/// Metrics: medl2_m2, mean_rel_l2, intensity_rmse, raydrop_accuracy, raydrop_trivial, drop_recall,
/// drop_precision, chamfer_m2 (METHOD section 13): median over the seeds with half of their range (the spread
/// of all rows except times), and
///   <metric>_from_monte_carlo   difference to monte_carlo with the same seed, %
///   <metric>_seeds              monte_carlo: half of the range of its seeds, % of their median
/// For the first seed: clipped, the share of the light of held-out sweeps outside the extents, %, and
/// projection_ms, the device time of the projection per sweep.
[[nodiscard]] std::vector<Row> run_table8(const std::string& device_request,
                                          const Table8Options& options,
                                          const Note& note);

}  // namespace simuli::bench
