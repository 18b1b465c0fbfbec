#pragma once
#include <functional>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"

namespace simuli::bench {

/// Renders the bench street from a moving rolling-shutter camera and a moving LiDAR, in float and where the
/// device can in double, and compares every ray with what another OpenCL implementation made of it. When
/// there is no `file` yet, the results are written to it (the reals as they are in memory) and compared with
/// themselves:
///   agreement/<camera|lidar>_<float|double>/rays_of_other_bits   share of rays that differ at all
///   agreement/camera_.../psnr                                    dB of colours of 0 to 1; 200 for the same
///   bits agreement/camera_.../largest                                 of 1 agreement/lidar_.../hit_otherwise
///   share of rays that only one of both hits agreement/lidar_.../range_p99, .../range_largest             m,
///   of rays that both hit
/// and, where the device has double precision, agreement/<camera|lidar>_own_double/...: the same of its float
/// results against its own double ones.
/// Error{kDevice} for no device, Error{kInput} when `file` can't be read or written or is no such file.
[[nodiscard]] std::vector<Row> run_agreement(const std::string& device_request,
                                             const std::string& file,
                                             const std::function<void(const std::string&)>& note);

}  // namespace simuli::bench
