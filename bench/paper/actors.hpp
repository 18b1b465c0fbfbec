#pragma once
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct ActorsOptions {
  int iterations = 300;  // per training
  int frames = 20;
  double noise_m = 0.2;    // standard deviation of a key pose's position along each axis of the road plane
  double noise_deg = 2.0;  // standard deviation of the heading
};

/// Evaluates the moving car of the street on held-out frames against the analytic street. Rows actors/...:
///   <without|with|moved|faster>/psnr_in_box     pixels of the car's box, dB; moved and faster: the edited
/// scene against the edited street
///   <..>/distance_in_box                        median error of returns in the box, cm
///   <..>/share_met                              share of these returns with is_met(), %
///   removed/psnr_where_it_was                   pixels of the box against the street without a car, dB
///   removed/distance_behind                     median error of rays that had hit the car, cm
///   removed/ghost_share                         share of rays with a background that return from the car's
/// position, %
///   noise/<kept|learned>/..                     as above with noisy key poses, fixed or learned
///   noise/<shift|turn>_<before|after|won_back>  error of key poses without their mean error, which the
/// particles absorb; cm, degrees, %
[[nodiscard]] std::vector<Row> run_actors(const std::string& device_request,
                                          const ActorsOptions& options,
                                          const Note& note);

}  // namespace simuli::bench
