#pragma once
// What a camera's picture has beside particles (METHOD section 9). Empty: the scene has none, and pays
// nothing.
#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "host/core/sensors/camera.hpp"

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
  /// Where the frames look, for cameras that none of them is of: not known, or known of all.
  std::vector<Camera> cameras;            // with those of the frames
  std::vector<Eigen::Quaterniond> looks;  // [frames] world_from_camera, in the middle of the exposure

  [[nodiscard]] bool empty() const { return frames.empty(); }
  [[nodiscard]] std::size_t values_per_frame() const;
  /// Grids that change nothing, one per frame.
  [[nodiscard]] static ColorGrids identity(int size_x, int size_y, int size_z, std::vector<Frame> frames);
  /// The grid of a picture of `camera` taken at `time_s`, [values_per_frame]. Of a camera that has grids:
  /// between its two neighbours in time, in proportion; beyond the first and the last theirs. Of another: each
  /// vertex has what these grids, of each camera that has some, do where they see the vertex's direction, and
  /// where none sees it, or looks are not known, nothing but their mean over the picture. A camera's only grid
  /// is for all its pictures, whichever way they look: of it there is its mean.
  [[nodiscard]] std::vector<float> at(const Camera& camera,
                                      const Eigen::Quaterniond& world_from_camera,
                                      double time_s) const;

 private:
  struct Part {  // of a mean
    std::size_t frame = 0;
    double weight = 0.0;
    const Camera* model = nullptr;  // by which add_towards() finds directions; null: it has none
  };
  /// The camera's neighbours in time; none of a camera without grids.
  [[nodiscard]] std::vector<Part> between(const std::string& camera, double time_s) const;
  /// Adds weight x what a frame's grid has in a direction to sum[size_z][12]; false where it doesn't see it.
  bool add_towards(const Eigen::Vector3d& direction_world, const Part& part, std::vector<double>& sum) const;
};

}  // namespace simuli
