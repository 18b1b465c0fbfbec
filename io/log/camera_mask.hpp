#pragma once
// Masks of the pixels in which a camera never sees the scene: the ego vehicle's hood and mirrors, a frame, dirt on the
// glass.
#include <cstdint>
#include <filesystem>
#include <vector>

#include "host/core/sensors/camera.hpp"
#include "io/picture/image.hpp"

namespace simuli {

/// The hidden pixels of all pictures of one camera.
struct CameraMask {
  int width = 0, height = 0;         // as of the camera
  std::vector<std::uint8_t> hidden;  // [height][width], 1: hidden, 0: the scene

  /// Whether pixel (x, y) of a picture of that size, which is at most the camera's, covers a hidden pixel.
  [[nodiscard]] bool hides(int x, int y, int picture_width, int picture_height) const;
  /// The share of hidden pixels, 0 to 1.
  [[nodiscard]] double hidden_share() const;
  /// Hides the pixels of another mask of the same camera as well.
  void add(const CameraMask& other);
};

/// Reads a mask from a picture whose first channel is not 0 in hidden pixels. A mask smaller or larger than the
/// camera's pictures is scaled (nearest pixel). Error{kInput} for an aspect ratio that is off by more than a pixel, for
/// a mask that hides everything, and for a file that is no picture.
[[nodiscard]] CameraMask read_camera_mask(const std::filesystem::path& file, const Camera& camera);

/// The value of all channels in hidden pixels; losses and scores leave these pixels out.
inline constexpr float kHiddenValue = -1.0F;
/// Sets the hidden pixels of a picture of any size up to the camera's to kHiddenValue.
void hide(const CameraMask& mask, Image& picture);

}  // namespace simuli
