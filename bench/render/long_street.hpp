#pragma once
#include <cstdint>

#include "bench/render/lidar_frames.hpp"

namespace simuli::bench {

struct LongStreetOptions {
  double length_m = 0.0;
  std::int64_t particles = 200'000;  // in 180 m of the street
  int frames = 21;                   // timed frames per place
  double detail = 0.5;               // RenderOptions::detail
};

/// Renders a 640 x 360 camera and a 64 x 2650 LiDAR at five places along a long street and half-way along the
/// street of 180 m, with and without culling of particle clusters, frames of both in turns:
///   long_street/<camera|lidar>/<metres>m_at_<place>/...
///   ... frame, project, bin             ms
///   ... processor                       ms of CPU time of this process per frame, for busy machines
///   ... <each of these>_of_all          ratio to the time without culling
///   ... <each of these>_detail          ratio to the time without levels of detail, with culling
///   ... visible_detail                  particles
///   ... psnr_detail, p99_detail         dB, and mm of rays that return in both
///   ... live                            % of the clusters
///   ... visible                         particles
/// and from one quarter of the long street to three quarters, one frame per metre, with only the needed pages
/// on the device (host/device/render/pages) and with all particles:
///   long_street/<camera|lidar>/drive/...
///   ... pages, places                   pages of the street, and capacity: a tenth more than the maximum per
/// frame
///   ... brought_a_metre, brought_at_once  pages
///   ... [all_]frame_median, frame_p99, processor_median, processor_p99    ms
///   ... [all_]device                    MB on the device, with all buffers of frames
[[nodiscard]] std::vector<Row> run_long_street(const std::string& device_request,
                                               const LongStreetOptions& options,
                                               const Progress& note);

}  // namespace simuli::bench
