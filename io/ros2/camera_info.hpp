#pragma once
// CameraInfo and cameras. Here pixel centres are at halves, in ROS at whole numbers: cx and cy differ by 0.5.
#include "host/core/sensors/camera.hpp"
#include "io/ros2/messages.hpp"

namespace simuli::ros2 {

/// Header left empty. plumb_bob, rational_polynomial or equidistant where the lens is one of these; any other
/// has the name of its own and D its parameters, in the order of lens_parameter_names(): who doesn't know it
/// should refuse it. Where a fisheye's map ends (max_angle_rad) has no place in equidistant.
[[nodiscard]] CameraInfoMessage camera_info_of(const Camera& camera);

/// The camera, with a global shutter. Error{kInput} naming `file` and the field of `where` for models that
/// there are not, counts of parameters that are not theirs, parts of pictures and binned ones.
[[nodiscard]] Camera camera_of(const CameraInfoMessage& info,
                               const std::string& name,
                               const std::string& file,
                               const std::string& where);

}  // namespace simuli::ros2
