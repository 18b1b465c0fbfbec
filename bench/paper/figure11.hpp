#pragma once
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct Figure11Options {
  std::string log;       // as open_drive() takes it; empty: the street from a fast, turning rig
  int iterations = 300;  // of each training
  int frames = 20;
  double speed_m_per_s = 15.0;
  double turn_deg_per_s = 45.0;  // of the rig about its vertical axis, left and right in turns
};

/// Figure 11 of the paper: a drive with the motion during each frame modelled (poses at its start and end) and
/// ignored (the pose in its middle). The street has a camera read out in 20 ms, a sweep of 100 ms.
///   figure11/camera/<modelled|ignored|gained>          PSNR of held-out pictures, dB
///   figure11/lidar/<modelled|ignored|gained>           median distance error of held-out sweeps, cm
///   figure11/<sensor>/ignored_when_rendering           trained with motion, rendered without
/// The camera's particles start from modelled sweeps both times, so that its row tells of the shutter alone.
[[nodiscard]] std::vector<Row> run_figure11(const std::string& device_request,
                                            const Figure11Options& options,
                                            const Note& note);

}  // namespace simuli::bench
