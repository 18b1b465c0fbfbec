#pragma once
// Appearance of a camera's pictures in addition to particles (METHOD section 9). Empty values mean none and
// cost nothing.
#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "host/core/sensors/camera.hpp"

namespace simuli {

/// Colour at infinite distance by world direction: an equirectangular picture, centre along +x, left half +y,
/// top +z.
struct EnvironmentMap {
  int width = 0;
  int height = 0;
  std::vector<float> texels;  // [height][width][3]

  [[nodiscard]] bool empty() const { return texels.empty(); }
};

/// Bilateral grids of affine colour transforms, one per training picture or camera: vertices over x and y of
/// the picture (the first and last on its borders) and over the luminance of the input colour (0 to 1).
struct ColorGrids {
  struct Frame {
    std::string camera;
    double time_s = 0.0;  // middle of the exposure
    bool operator==(const Frame&) const = default;
  };
  static constexpr std::size_t kMatrix = 12;  // 3 rows of 4, the last column is added

  int size_x = 0;
  int size_y = 0;
  int size_z = 0;
  std::vector<Frame> frames;
  std::vector<float> values;  // [frames][size_y][size_x][size_z][12]
  /// Viewing directions of the frames, for cameras without grids: known for none or for all.
  std::vector<Camera> cameras;  // the cameras of the frames
  std::vector<Eigen::Quaterniond> looks;  // [frames] world_from_camera, in the middle of the exposure

  [[nodiscard]] bool empty() const { return frames.empty(); }
  [[nodiscard]] std::size_t values_per_frame() const;
  /// Returns identity grids, one per frame.
  [[nodiscard]] static ColorGrids identity(int size_x, int size_y, int size_z, std::vector<Frame> frames);
  /// Returns the grid of a picture of `camera` at `time_s`, [values_per_frame]. For a camera with grids:
  /// interpolated linearly between its neighbours in time, constant beyond the ends. For another camera: each
  /// vertex combines the grids of all cameras at the vertex's direction where they see it; elsewhere, or with
  /// unknown directions, it has their mean over the picture. A camera's only grid is for pictures in all
  /// directions; its mean is used.
  [[nodiscard]] std::vector<float> at(const Camera& camera,
                                      const Eigen::Quaterniond& world_from_camera,
                                      double time_s) const;

 private:
  struct Part {  // one term of a mean
    std::size_t frame = 0;
    double weight = 0.0;
    const Camera* model = nullptr;  // used by add_towards() for directions; null: none
  };
  /// Returns the camera's neighbours in time; empty for a camera without grids.
  [[nodiscard]] std::vector<Part> between(const std::string& camera, double time_s) const;
  /// Adds weight times a frame's grid in a direction to sum[size_z][12]; false where the frame does not see it.
  bool add_towards(const Eigen::Vector3d& direction_world, const Part& part, std::vector<double>& sum) const;
};

}  // namespace simuli
