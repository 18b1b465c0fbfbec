#pragma once
// Sweeps as NCore's ray bundles: unit directions from the sensor's origin to the ray's end in single precision,
// times in microseconds, distances from the sensor's origin. For io/ncore, io/import/ncore and tests.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli::ncore {

/// N rays. NCore supports several returns per ray; this project uses one.
struct RayBundle {
  std::vector<float> direction;             // [N][3]
  std::vector<std::uint64_t> timestamp_us;  // [N]
  std::vector<std::uint16_t> element;       // [N][2] row, column; empty: unknown
  std::vector<float> distance;              // [N] m; NaN: no return
  std::vector<float> intensity;             // [N] 0 to 1; NaN: no return

  [[nodiscard]] std::size_t count() const { return timestamp_us.size(); }
};

/// Start and end time of a frame.
struct FrameTime {
  std::uint64_t start_us = 0, end_us = 0;
};

/// Rays of a sweep that a bundle does not represent exactly: index and exact azimuth, elevation, time fraction
/// and distance.
struct Exact {
  std::vector<std::uint32_t> ray;
  std::vector<float> values;  // [rays][4]
};

/// A model's grid in NCore's terms, shared by all of its sweeps.
class RayGrid {
 public:
  explicit RayGrid(const LidarModel& model);

  /// Returns all rays of a sweep in row-major order.
  [[nodiscard]] RayBundle bundle(const Sweep& sweep, const FrameTime& time) const;
  /// Converts a bundle to a sweep; unlisted rays have no return. Rays that agree with the model's direction and
  /// time get the model's exact values. Of a ray listed twice the first is used (`twice` counts the others).
  /// Without elements the rays are the model's in order. Throws Error{kInput} naming `file` for invalid
  /// elements, and for a wrong number of rays without elements.
  [[nodiscard]] Sweep sweep(const RayBundle& bundle,
                            const FrameTime& time,
                            const std::string& file,
                            std::size_t& twice) const;
  /// Returns the rays that sweep(bundle(..)) does not reproduce exactly.
  [[nodiscard]] Exact lost(const Sweep& sweep, const RayBundle& bundle, const FrameTime& time) const;
  /// Restores exact values that agree with the bundle within its precision.
  void restore(const Exact& exact, Sweep& sweep) const;

  [[nodiscard]] const LidarModel& model() const { return model_; }

 private:
  LidarModel model_;
  LidarRays nominal_;
  bool has_elements_ = false;
};

}  // namespace simuli::ncore
