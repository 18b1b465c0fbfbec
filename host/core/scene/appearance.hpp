#pragma once
// What a camera's picture has beside particles (METHOD section 9). Empty: the scene has none, and pays
// nothing.
#include <array>
#include <string>
#include <vector>

namespace simuli {

/// Colour that comes from infinitely far, by world direction: an equirectangular picture, centre along +x,
/// left half +y, top +z.
struct EnvironmentMap {
  int width = 0;
  int height = 0;
  std::vector<float> texels;  // [height][width][3]

  [[nodiscard]] bool empty() const { return texels.empty(); }
};

/// A bilateral grid of affine colour transforms for each training picture: vertices over x and y of the
/// picture (the first and last on its borders) and over the luminance of the colour that goes in (0 to 1).
struct ColorGrids {
  struct Frame {
    std::string camera;
    double time_s = 0.0;  // middle of the exposure
    bool operator==(const Frame&) const = default;
  };
  static constexpr std::size_t kMatrix = 12;  // 3 rows of 4, the last column added

  int size_x = 0;
  int size_y = 0;
  int size_z = 0;
  std::vector<Frame> frames;
  std::vector<float> values;  // [frames][size_y][size_x][size_z][12]

  [[nodiscard]] bool empty() const { return frames.empty(); }
  [[nodiscard]] std::size_t values_per_frame() const;
  /// Grids that change nothing, one per frame.
  [[nodiscard]] static ColorGrids identity(int size_x, int size_y, int size_z, std::vector<Frame> frames);
  /// The grid of a picture taken at `time_s`, [values_per_frame]: between those of the camera's two
  /// neighbours in time, in proportion; beyond the first and the last theirs; empty when the camera has none.
  [[nodiscard]] std::vector<float> at(const std::string& camera, double time_s) const;
};

}  // namespace simuli
