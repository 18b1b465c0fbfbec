#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli::bench {

/// Returns the device time in ms of each stage in a profile: rays, project, sort, bin, blend and their
/// backward passes.
[[nodiscard]] std::map<std::string, double> stage_times(Profile& profile);

struct StagesOptions {
  std::int64_t particles = 200'000;
  int sh_degree = 3;
  int frames = 21;  // timed frames, after two warm-up frames
  std::uint64_t seed = 1;
};

/// Times each stage of a frame and of its backward pass, for a 640 x 360 camera and a 64 x 2650 LiDAR, with
/// the device's lane shape and with one work-item per ray, frames of both in turns in one run:
///   stages/<camera_640x360|lidar_64x2650>_<n>k/<stage>         ms of device time, median of frames
///   stages/.../frame                                           ms from the call to the result on the device
///   stages/.../blend_one_ray_per_item, .../blend_speedup       ms, ratio
///   stages/.../frame_shuffled, .../frame_of_shuffled           ms of a frame with the particles in random
/// order (the worst case), and the frame's share of it
///   stages/.../<stage>/arithmetic, .../traffic                 MFLOP, MB (bench/render/roofline.hpp)
///   stages/.../<stage>/arithmetic_of_peak, .../traffic_of_peak share of stages/peak/fma, .../bandwidth, %
[[nodiscard]] std::vector<Row> run_stages(const std::string& device_request,
                                          const StagesOptions& options,
                                          const std::function<void(const std::string&)>& note);

}  // namespace simuli::bench
