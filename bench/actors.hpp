#pragma once
#include <string>
#include <vector>

#include "bench/fit.hpp"
#include "bench/measure.hpp"

namespace simuli::bench {

struct ActorsOptions {
  int iterations = 300;  // of each training
  int frames = 20;
  double noise_m = 0.2;    // standard deviation of a key pose's position along each axis of the road's plane
  double noise_deg = 2.0;  // and of its heading
};

/// The street's moving car, held-out frames, against the analytic street:
///   actors/<with|without>/psnr_in_box                 pixels that look at the car's box, dB
///   actors/<with|without>/distance_in_box             returns inside it, median, cm
///   actors/<moved|removed|faster>/psnr_in_box         the scene edited, against the edited street, dB
///   actors/<moved|faster>/distance_in_box             cm
///   actors/removed/<psnr_where_it_was|ghost_share>    ghost: share of the rays that met the car and still
///   end in
///                                                     its box
///   actors/noise/<shift|turn>_<before|after|won_back> error of the key poses but for what they have in
///   common,
///                                                     which the particles take up; cm, degrees, %
[[nodiscard]] std::vector<Row> run_actors(const std::string& device_request,
                                          const ActorsOptions& options,
                                          const Note& note);

}  // namespace simuli::bench
