#pragma once
// Outputs of a camera's frame in addition to colours.
#include <string>
#include <string_view>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"

namespace simuli {

/// A distance is measured from the camera along the pixel's ray, m; a depth is its component along the optical
/// axis (z). The median is where transmittance falls to 1/2, 0 where it stays above. The mean is the expected
/// distance over the blended particles, without the background; it lies between surfaces where several share a
/// pixel.
enum class CameraOutput {
  kRgb,
  kDepth,
  kMeanDepth,
  kDistance,
  kMeanDistance,
  kOpacity,  // [0, 1]: 1 minus the transmittance
  kActors,  // Frame::actors(): the actor at kDistance
  kNormals,  // [3] in the camera frame at the pixel's time, towards the camera; zeros: none
  kSupport,  // [0, 1] support; computed by SupportOnDevice::image_of() (host/device/support/support.hpp)
  kFlow,  // [3] optical flow to another shot: Flow::pixels of flow_of() (flow.hpp)
  kSceneFlow  // [3] m: Flow::points
};
/// Returns "rgb", "depth", "mean_depth", "distance", "mean_distance", "opacity", "actors", "normals",
/// "support", "flow", "scene_flow", in the order of the values.
[[nodiscard]] const std::vector<std::string>& camera_output_names();
/// Throws Error{kUsage} with the known names.
[[nodiscard]] CameraOutput camera_output(std::string_view name);

/// Returns `request` extended by the inputs of the outputs.
[[nodiscard]] FrameRequest request_for(const std::vector<CameraOutput>& outputs, FrameRequest request = {});

/// Returns [height][width][1], for kRgb and kNormals [3]. A normal is that of the plane through the points at
/// kDistance of 7 x 7 pixels, without those whose distance differs by more than a tenth. Throws Error{kUsage}
/// for a LiDAR, for kSupport, kFlow and kSceneFlow, which need more than the frame, and for data that the frame
/// was not requested with.
[[nodiscard]] Image image_of(const Frame& frame, CameraOutput output);

}  // namespace simuli
