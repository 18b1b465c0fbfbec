#pragma once
// What in a camera's pictures is never the scene: the vehicle's own hood and mirrors, a frame, dirt on the
// glass.
#include <cstdint>
#include <filesystem>
#include <vector>

#include "host/core/sensors/camera.hpp"
#include "io/picture/image.hpp"

namespace simuli {

/// Of all of a camera's pictures.
struct CameraMask {
  int width = 0, height = 0;         // the camera's
  std::vector<std::uint8_t> hidden;  // [height][width], 1: not the scene

  /// Whether anything hidden is in pixel (x, y) of a picture of that size, at most the camera's.
  [[nodiscard]] bool hides(int x, int y, int picture_width, int picture_height) const;
  /// Of all pixels, 0 to 1.
  [[nodiscard]] double hidden_share() const;
  /// Takes what another one of the same camera hides.
  void add(const CameraMask& other);
};

/// What is not 0 in a picture's first channel is hidden. A mask smaller or larger than the camera's pictures
/// is scaled (nearest). Error{kInput} for another shape than the camera's, by more than a pixel, for one
/// that hides everything, and for what is no picture.
[[nodiscard]] CameraMask read_camera_mask(const std::filesystem::path& file, const Camera& camera);

/// What pictures hold in all channels where nothing is known of the scene: losses and scores leave it out.
inline constexpr float kHiddenValue = -1.0F;
/// Marks the hidden pixels of a picture of any size up to the camera's.
void hide(const CameraMask& mask, Image& picture);

}  // namespace simuli
