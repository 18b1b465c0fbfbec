#pragma once
// Common parts of tests of device code: scene cases that use the same few program variants (each variant
// takes seconds to compile), and their sensors for kernels and reference.
#include <gtest/gtest.h>
#include <iosfwd>
#include <vector>

#include "host/device/render/scene/renderer.hpp"
#include "tests/support/reference.hpp"
#include "tests/support/scenes.hpp"

namespace simuli::test {

/// A sensor with the parameters that specialise its kernels.
struct SceneCase {
  const char* name;
  SetKind kind;
  bool moving;
  bool levers;  // LiDAR beams start at offsets from the sensor's origin
  int sh_degree;
};
void PrintTo(const SceneCase& scene_case, std::ostream* out);

inline constexpr SceneCase kCameraStill{"camera", SetKind::kCamera, false, false, 0};
inline constexpr SceneCase kCameraSh3{"camera_sh3", SetKind::kCamera, false, false, 3};
inline constexpr SceneCase kCameraRolling{"camera_rolling", SetKind::kCamera, true, false, 1};
inline constexpr SceneCase kLidarStill{"lidar", SetKind::kLidar, false, false, 2};
inline constexpr SceneCase kLidarLevers{"lidar_levers", SetKind::kLidar, false, true, 0};
inline constexpr SceneCase kLidarMoving{"lidar_moving", SetKind::kLidar, true, true, 1};

inline constexpr LaneShape kDefaultShape{0, 0, 0};  // shape of the device
inline constexpr LaneShape kCpuShape{16, 16, 1};
inline constexpr LaneShape kGpuShape{1, 1, 256};

/// One sensor in one view.
struct Shot {
  SetKind kind = SetKind::kCamera;
  Camera camera;
  Lidar lidar;
  LidarRays rays;
  View view;

  [[nodiscard]] SensorRays on(const Device& device, const RenderOptions& options) const;
  [[nodiscard]] reference::Sensor reference() const;
};

/// Cameras point along +x with `width` x `height` pixels; LiDARs have columns x beams of a full revolution
/// from azimuth pi and a range of 1 to 80 m. A moving sensor moves 0.6 m along x and rotates by 0.06 rad
/// during the frame.
[[nodiscard]] Shot shot_of(const SceneCase& scene_case, int width, int height);

/// Returns a set with the kind and degree of the case.
[[nodiscard]] GaussianSet set_for(const SceneCase& scene_case, SetRecipe recipe, std::uint64_t seed);

/// Returns all outputs of a pass, [5][slots], in device order.
[[nodiscard]] std::vector<double> outputs(const Pass& pass);
/// values[channels][slots] -> [channels][rays] in ray order, without slots that have no ray.
[[nodiscard]] std::vector<double> by_ray(const SensorRays& rays, const std::vector<double>& values);

// Results are compared as floats. A float pipeline adds the rounding of directions (6e-8) against scales
// of a few centimetres some metres away, squared distances up to 11 and hundreds of terms.
struct Tolerance {
  double transmittance;
  double feature;     // features are up to 4 times the range of the transmittance
  double distance_m;  // sums of weights times up to 20 m
  double decided;     // rays with a decision within this margin may differ
};
inline constexpr Tolerance kDoubleTolerance{2e-6, 8e-6, 4e-5, 1e-6};
inline constexpr Tolerance kFloatTolerance{3e-3, 1.2e-2, 6e-2, 1e-3};

struct RayCounts {
  double compared = 0;  // share of rays with certain decisions
  double covered = 0;   // share of these rays on a particle
};
/// Fails at the first certain ray with a wrong result; medians are only tested for LiDARs.
RayCounts expect_same_rays(const RayResults& results,
                           const std::vector<reference::RayResult>& expected,
                           SetKind kind,
                           const Tolerance& tolerance);

/// Fails unless the drop logits of a LiDAR equal the view's function of the rays' results; a camera has none.
void expect_drop_logits(const RayResults& results, const View& view, SetKind kind);

/// Whether the default device supports double; otherwise tests in double are skipped.
[[nodiscard]] bool has_double(const Device& device);
#define SIMULI_NEEDS_DOUBLE(device)                                                     \
  if (!simuli::test::has_double(device)) {                                              \
    GTEST_SKIP() << "not run: comparisons in double precision, the device has no fp64"; \
  }                                                                                     \
  static_assert(true)
/// GPUs reserve private memory of all resident work-items, which does not suffice for windows and lists of 16
/// rays each.
#define SIMULI_NEEDS_WINDOWS(device, shape)                                         \
  if (!(device).info().is_cpu && (shape).lanes > 1) {                               \
    GTEST_SKIP() << "not run: windows of vectors, which no GPU has the memory for"; \
  }                                                                                 \
  static_assert(true)

}  // namespace simuli::test
