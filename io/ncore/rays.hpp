#pragma once
// Sweeps as NCore's bundles of rays: unit directions from the sensor's origin to where the ray ends, in
// single precision; times in microseconds; distances from the sensor's origin. For io/ncore, io/import/ncore
// and tests.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli::ncore {

/// N rays. NCore holds more returns than one of a ray; here it is one.
struct RayBundle {
  std::vector<float> direction;             // [N][3]
  std::vector<std::uint64_t> timestamp_us;  // [N]
  std::vector<std::uint16_t> element;       // [N][2] row, column; empty: not told
  std::vector<float> distance;              // [N] m; NaN: nothing returned
  std::vector<float> intensity;             // [N] 0 to 1; NaN: nothing returned

  [[nodiscard]] std::size_t count() const { return timestamp_us.size(); }
};

/// When a frame was recorded.
struct FrameTime {
  std::uint64_t start_us = 0, end_us = 0;
};

/// What a bundle lost of its sweep: rays and their exact azimuth, elevation, time fraction and distance.
struct Exact {
  std::vector<std::uint32_t> ray;
  std::vector<float> values;  // [rays][4]
};

/// The grid of a model in NCore's terms, once for all of its sweeps.
class RayGrid {
 public:
  explicit RayGrid(const LidarModel& model);

  /// All rays of a sweep in row-major order.
  [[nodiscard]] RayBundle bundle(const Sweep& sweep, const FrameTime& time) const;
  /// A sweep from a bundle; what the bundle doesn't list returned nothing. Rays that look and fire as the
  /// model's own have the model's own angles and times. A ray listed twice counts once (`twice` of them were
  /// left out). Rays without elements are the model's in their order. Error{kInput} naming `file` for
  /// elements that the model has not, and another number of rays without.
  [[nodiscard]] Sweep sweep(const RayBundle& bundle,
                            const FrameTime& time,
                            const std::string& file,
                            std::size_t& twice) const;
  /// What sweep(bundle(..)) makes of rays is not bit for bit theirs.
  [[nodiscard]] Exact lost(const Sweep& sweep, const RayBundle& bundle, const FrameTime& time) const;
  /// Puts it back where it agrees with what the bundle says, as far as that is precise.
  void restore(const Exact& exact, Sweep& sweep) const;

  [[nodiscard]] const LidarModel& model() const { return model_; }

 private:
  LidarModel model_;
  LidarRays nominal_;
  bool has_elements_ = false;
};

}  // namespace simuli::ncore
