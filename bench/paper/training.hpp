#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct TrainingBenchOptions {
  std::vector<std::int64_t> particles = {50'000, 200'000, 1'000'000};  // per set
  int iterations = 20;  // timed iterations, after two that compile
};

/// Times an iteration of training by stage at several sizes, with one picture of 320 x 180 and one sweep of
/// the street, anchors, losses and noise, SH degrees 2 and 1:
///   training/<n>k/<stage>          ms of device time per iteration
///   training/<n>k/iteration        ms from the call to the result
///   training/<n>k/anchor_search    ms, once every 1000 iterations
///   training/<n>k/anchor_share     % of the time of 1000 iterations, with the search
///   training/<n>k/memory_peak      GB of device buffers, and .../memory_told, the estimate
[[nodiscard]] std::vector<Row> run_training(const std::string& device_request,
                                            const TrainingBenchOptions& options,
                                            const Note& note);

}  // namespace simuli::bench
