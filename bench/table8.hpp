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

/// Table 8 of the paper: the three projections, each trained and then compared with held-out sweeps.
///   table8/<unscented|linearized|monte_carlo>/<metric>         trained and rendered with that projection
///   table8_render/<projection>/<metric>                        trained with unscented, rendered with that
///   table8_coarse/..., table8_coarse_render/...                the same with few large particles
///   table8_clipped/<projection>/size_<5|10|20|30>_percent      single long particles of that share of their
///   range:
///                                              how much of what rays gather of them the box cuts off, in %
/// Metrics: medl2_m2, mean_rel_l2, intensity_rmse, raydrop_accuracy, chamfer_m2 (METHOD section 13), the
/// projection's device time per sweep, and worst_difference: of the five from those of monte_carlo, in %.
[[nodiscard]] std::vector<Row> run_table8(const std::string& device_request,
                                          const Table8Options& options,
                                          const Note& note);

}  // namespace simuli::bench
