#pragma once
// What a camera's frame tells beside its colours.
#include <string>
#include <string_view>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"

namespace simuli {

/// A distance is from the camera along the pixel's ray, m; a depth its part along the optical axis (z). Where
/// half of the pixel's light is gone, and 0 where more than half of it goes on; or the mean of where the
/// light comes from, what comes from behind all particles left out, which lies between surfaces where several
/// share a pixel.
enum class CameraOutput {
  kRgb,
  kDepth,
  kMeanDepth,
  kDistance,
  kMeanDistance,
  kOpacity,  // [0, 1]: 1 less the light that goes on
  kActors,   // Frame::actors(): who is at kDistance
  kNormals,  // [3] in the camera's axes at the pixel's time, towards the camera; zeros: none
  kSupport,  // [0, 1]: how well it is known; SupportOnDevice::image_of() (host/device/support/support.hpp) tells it
  kFlow,      // [3] to another shot: Flow::pixels of flow_of() (flow.hpp)
  kSceneFlow  // [3] m: Flow::points
};
/// "rgb", "depth", "mean_depth", "distance", "mean_distance", "opacity", "actors", "normals", "support", "flow",
/// "scene_flow": in the order of the values.
[[nodiscard]] const std::vector<std::string>& camera_output_names();
/// Error{kUsage} naming those there are.
[[nodiscard]] CameraOutput camera_output(std::string_view name);

/// `request` with what the outputs need beside pictures.
[[nodiscard]] FrameRequest request_for(const std::vector<CameraOutput>& outputs, FrameRequest request = {});

/// [height][width][1], of kRgb and kNormals [3]. A normal is that of the plane through the points at
/// kDistance of 7 x 7 pixels, without those whose distance differs by more than a tenth. Error{kUsage} of a
/// LiDAR, of kSupport, kFlow and kSceneFlow, which take more than the frame, or for what the frame was not asked
/// for.
[[nodiscard]] Image image_of(const Frame& frame, CameraOutput output);

}  // namespace simuli
