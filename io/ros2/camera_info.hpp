#pragma once
// Conversion of cameras and CameraInfo. In this project pixel centres are at halves, in ROS at integers: cx and
// cy differ by 0.5.
#include "host/core/sensors/camera.hpp"
#include "io/ros2/messages.hpp"

namespace simuli::ros2 {

/// Returns the message without a header. Lenses use plumb_bob, rational_polynomial or equidistant if possible;
/// other lenses have a name of this project and D contains their parameters in the order of
/// lens_parameter_names(); unaware readers should refuse them. equidistant has no field for the limit of a
/// fisheye (max_angle_rad).
[[nodiscard]] CameraInfoMessage camera_info_of(const Camera& camera);

/// Returns the camera with a global shutter. Throws Error{kInput} naming `file` and the field of `where` for
/// unknown models, wrong numbers of parameters, regions of interest and binning.
[[nodiscard]] Camera camera_of(const CameraInfoMessage& info,
                               const std::string& name,
                               const std::string& file,
                               const std::string& where);

}  // namespace simuli::ros2
