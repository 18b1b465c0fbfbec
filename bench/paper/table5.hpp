#pragma once
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct Table5Options {
  std::string log;       // in the format of open_drive(); empty: the embedded street
  int iterations = 400;  // per training
};

/// Table 5 of the paper: factorised sets with anchoring, environment and bilateral grids ("full"), the same
/// without one of these, and one set for both sensors with distance losses of weight 0, 0.001, 0.01 and 0.1,
/// all with the same initialisation and frames.
///   table5/<unified_0|unified_0.001|unified_0.01|unified_0.1>/<metric>
///   table5/<without_grid|without_environment|without_anchor|full>/<metric>
/// Metrics on held-out frames: psnr_db, chamfer_m2, distance_median_cm, camera_mp_per_s, lidar_mr_per_s,
/// particles.
[[nodiscard]] std::vector<Row> run_table5(const std::string& device_request,
                                          const Table5Options& options,
                                          const Note& note);

}  // namespace simuli::bench
