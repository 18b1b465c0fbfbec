#pragma once
#include <cstdint>

#include "bench/render/lidar_frames.hpp"

namespace simuli::bench {

struct LongStreetOptions {
  double length_m = 0.0;
  std::int64_t particles = 200'000;  // of 180 m of it
  int frames = 21;                   // timed at each place
  double detail = 0.5;               // RenderOptions::detail
};

/// A 640 x 360 camera and a 64 x 2650 LiDAR at five places along a long street and half-way down the one of
/// 180 m, with clusters of particles left out that the sensor cannot see and without, frames of both in
/// turns:
///   long_street/<camera|lidar>/<metres>m_at_<place>/...
///   ... frame, project, bin             ms
///   ... processor                       ms of this process in a frame: what to read on a busy machine, of
///   CPUs
///   ... <each of these>_of_all          its share of that with all clusters looked at
///   ... <each of these>_detail          its share of that without, with levels of detail; clusters left out
///   ... visible_detail                  particles
///   ... psnr_detail, p99_detail         dB, and mm of rays that return in both
///   ... live                            % of the clusters
///   ... visible                         particles
/// and from a quarter of the long one to three quarters of it, a frame a metre, with that alone on the device
/// which frames may see (host/device/render/pages) and with all of it:
///   long_street/<camera|lidar>/drive/...
///   ... pages, places                   of the street, and room for: a tenth more than a frame sees at most
///   ... brought_a_metre, brought_at_once  pages
///   ... [all_]frame_median, frame_p99, processor_median, processor_p99    ms
///   ... [all_]device                    MB of the device, with all that a frame keeps
[[nodiscard]] std::vector<Row> run_long_street(const std::string& device_request,
                                               const LongStreetOptions& options,
                                               const Progress& note);

}  // namespace simuli::bench
