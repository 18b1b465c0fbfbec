#pragma once
#include <functional>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"

namespace simuli::bench {

/// Renders the bench street with a moving rolling-shutter camera and a moving LiDAR, in float and, if the
/// device supports it, in double, and compares each ray with the results of another OpenCL implementation. If
/// `file` does not exist, the results are written to it (raw reals) and compared with themselves:
///   agreement/<camera|lidar>_<float|double>/rays_of_other_bits   share of rays with any difference
///   agreement/camera_.../psnr         dB of colours in [0, 1]; 200 for identical bits
///   agreement/camera_.../largest      colour error in [0, 1]
///   agreement/lidar_.../hit_otherwise share of rays with a return in only one of both
///   agreement/lidar_.../range_p99, .../range_largest   m, of rays with a return in both
/// and with double precision agreement/<camera|lidar>_own_double/...: the same for the device's float results
/// against its double results. Throws Error{kDevice} without a device, Error{kInput} for an unreadable,
/// unwritable or invalid `file`.
[[nodiscard]] std::vector<Row> run_agreement(const std::string& device_request,
                                             const std::string& file,
                                             const std::function<void(const std::string&)>& note);

}  // namespace simuli::bench
