#pragma once
// Frames of a log as training and evaluation see them: pictures at one scale, views from the scene origin,
// LiDAR truth beside its measured rays.
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

/// The camera with sides of ceil(scale * side) pixels. Error{kUsage} unless they are 1 to 65 536.
[[nodiscard]] Camera scaled_camera(const Camera& camera, double scale);

/// The picture of `frame`, averaged down to the size of `scaled` (scaled_camera of the frame's camera);
/// kHiddenValue wherever the camera's masks hide anything.
/// Error{kInput} when the file's size is not the log camera's, Error{kUsage} when `scaled` is larger.
[[nodiscard]] Image load_image(const Log& log, const ImageFrame& frame, const Camera& scaled);

/// Says that these are loaded next at that scale, in this order (log.files).
void expect(const Log& log, const std::vector<const ImageFrame*>& frames, double image_scale);
/// What load_image() reads of a frame's file.
[[nodiscard]] FrameFiles::Wish wish_of(const Log& log, const ImageFrame& frame, const Camera& scaled);

/// Where the frame's sensor was when it was taken.
[[nodiscard]] Shot shot_of(const Log& log, const ImageFrame& frame);
[[nodiscard]] Shot shot_of(const Log& log, const SweepFrame& frame);
/// The same as the scene's renderer takes it.
[[nodiscard]] View view_of(const Log& log, const Scene& scene, const ImageFrame& frame);
[[nodiscard]] View view_of(const Log& log, const Scene& scene, const SweepFrame& frame);

/// The channels of an interleaved picture, one behind the other: [3][height][width].
[[nodiscard]] std::vector<float> planar(const Image& image);

}  // namespace simuli
