#pragma once
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct ActorsOptions {
  int iterations = 300;  // of each training
  int frames = 20;
  double noise_m = 0.2;    // standard deviation of a key pose's position along each axis of the road's plane
  double noise_deg = 2.0;  // and of its heading
};

/// The street's moving car, held-out frames, against the analytic street. Below actors/:
///   <without|with|moved|faster>/psnr_in_box     pixels that look at the car's box, dB; the last two: the
///                                               scene edited, against the street so edited
///   <..>/distance_in_box                        returns inside it: median error, cm
///   <..>/share_met                              of them, those that is_met(), %
///   removed/psnr_where_it_was                   pixels of its box, against the street without a car, dB
///   removed/distance_behind                     rays that met it, against the same, median, cm
///   removed/ghost_share                         of those that should end elsewhere, the share that
///                                               returns from where the car was, %
///   noise/<kept|learned>/..                     as above with noisy key poses, as they are or learned
///   noise/<shift|turn>_<before|after|won_back>  error of the key poses but for what they have in common,
///                                               which the particles take up; cm, degrees, %
[[nodiscard]] std::vector<Row> run_actors(const std::string& device_request,
                                          const ActorsOptions& options,
                                          const Note& note);

}  // namespace simuli::bench
