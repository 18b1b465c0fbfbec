#pragma once
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct Figure11Options {
  std::string log;       // in the format of open_drive(); empty: the street with a fast, rotating rig
  int iterations = 300;  // per training
  int frames = 20;
  double speed_m_per_s = 15.0;
  double turn_deg_per_s = 45.0;  // of the rig about its vertical axis, alternately left and right
};

/// Figure 11 of the paper: a drive with the motion during each frame modelled (poses at its start and end)
/// and ignored (pose in its middle). The street has a camera readout of 20 ms and a sweep period of 100 ms.
///   figure11/camera/<modelled|ignored|gained>          PSNR of held-out pictures, dB
///   figure11/lidar/<modelled|ignored|gained>           median distance error of held-out sweeps, cm
///   figure11/<sensor>/ignored_when_rendering           trained with motion, rendered without
/// The camera set is initialised from modelled sweeps in both cases, so that its row measures only the
/// shutter.
[[nodiscard]] std::vector<Row> run_figure11(const std::string& device_request,
                                            const Figure11Options& options,
                                            const Note& note);

}  // namespace simuli::bench
