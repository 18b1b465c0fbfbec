#pragma once
// "Model only what the scene requires": what each optional part of a frame costs present, absent, and never
// mentioned.
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct PlanOptions {
  std::int64_t particles = 200'000;
  int repeats = 21;  // frames of each, taken in turns
};

/// The bench street in three ways for each part: with it; without it, but said so (poses that don't differ,
/// an actor without particles, an empty environment, no grids, bands left out, a beam of no width); and as if
/// there were no such thing. Rows
///   plan/<part>/<present|absent|never>/frame       ms, median
///   plan/<part>/<present|absent>/over_never        ratio of frames taken in turns
///   plan/<part>/<present|absent|never>/memory      MB of device buffers
[[nodiscard]] std::vector<Row> run_plan(const std::string& device_request,
                                        const PlanOptions& options,
                                        const Note& note);

}  // namespace simuli::bench
