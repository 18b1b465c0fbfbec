#pragma once
// Frames of a log for training and evaluation: pictures at one scale, views relative to the scene origin, LiDAR
// measurements with their rays.
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/view.hpp"
#include "io/log/frame_files.hpp"
#include "io/log/log.hpp"
#include "io/picture/image.hpp"

namespace simuli {

/// Returns the camera with sides of ceil(scale * side) pixels. Throws Error{kUsage} unless they are 1 to 65
/// 536.
[[nodiscard]] Camera scaled_camera(const Camera& camera, double scale);

/// Returns the picture of `frame`, averaged to the size of `scaled` (scaled_camera of the frame's camera), with
/// kHiddenValue in masked pixels. Throws Error{kInput} when the file's size differs from the log camera's,
/// Error{kUsage} when `scaled` is larger.
[[nodiscard]] Image load_image(const Log& log, const ImageFrame& frame, const Camera& scaled);

/// Announces the next frames at that scale, in order (log.files).
void expect(const Log& log, const std::vector<const ImageFrame*>& frames, double image_scale);
/// Returns the files that load_image() reads for a frame.
[[nodiscard]] FrameFiles::Wish wish_of(const Log& log, const ImageFrame& frame, const Camera& scaled);

/// Returns the shot of a recorded frame.
[[nodiscard]] Shot shot_of(const Log& log, const ImageFrame& frame);
[[nodiscard]] Shot shot_of(const Log& log, const SweepFrame& frame);
/// Returns the view of a recorded frame for the scene's renderer.
[[nodiscard]] View view_of(const Log& log, const Scene& scene, const ImageFrame& frame);
[[nodiscard]] View view_of(const Log& log, const Scene& scene, const SweepFrame& frame);

/// Returns the channels of an interleaved picture as planes: [3][height][width].
[[nodiscard]] std::vector<float> planar(const Image& image);

}  // namespace simuli
