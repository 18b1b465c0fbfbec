#pragma once
// "Model only what the scene requires": costs of each optional part of a frame if present, absent, or never
// configured.
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct PlanOptions {
  std::int64_t particles = 200'000;
  int repeats = 21;  // frames per variant, in turns
};

/// Renders the bench street in three variants for each part: present; absent but configured (equal poses, an
/// actor without particles, an empty environment, no grids, empty bands, a beam without width); and never
/// configured. Rows:
///   plan/<part>/<present|absent|never>/frame       ms, median
///   plan/<part>/<present|absent>/over_never        ratio of frames taken in turns
///   plan/<part>/<present|absent|never>/memory      MB of device buffers
[[nodiscard]] std::vector<Row> run_plan(const std::string& device_request,
                                        const PlanOptions& options,
                                        const Note& note);

}  // namespace simuli::bench
