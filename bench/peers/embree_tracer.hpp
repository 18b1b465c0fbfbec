#pragma once
// The peer of `simuli bench --peers`: the same particles, ray traced on Embree. It shares no code with the
// kernels, and no header with Eigen, since it is compiled for the processor at hand.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cl/shared/sensor_constants.h"

namespace simuli::bench {

/// Particles of one set, parameter by parameter as in GaussianSet::params: values[param_rows][count].
struct TracedSet {
  std::span<const float> values;
  std::size_t count = 0;
  int sh_degree = 0;
  int clamped_channels = 3;  // features that are biased by 1/2 and not negative: 3 colours, or the intensity
};

/// One frame of a sensor.
struct TracedFrame {
  shared::SensorConstants<double> constants;  // poses, footprint, cuts, background
  bool moving = false;
};

/// Rays in the sensor's frame, packet by packet; those with a zero direction are not traced. Each [count], a
/// multiple of EmbreeTracer::kPacket.
struct TracedRays {
  std::vector<float> direction[3];  // unit
  std::vector<float> origin[3];     // m; empty: all start at the sensor's origin
  std::vector<float> time;          // share of the frame
};

/// What each of the rays saw, as RayResults.
struct TracedResults {
  std::vector<float> feature[3];
  std::vector<float> transmittance;
  std::vector<float> distance;  // sum of w tau, m
  std::vector<float> median;    // m, 0 where transmittance stays above 1/2
};

/// Every particle is a user geometry's primitive with the box of the ellipsoid at which its alpha falls to
/// the cut; rays go in packets, gather the nearest kWindow responses behind those of the last round, blend
/// them, and go on until the transmittance cut. Two particles at the same float distance count once where a
/// round ends between them.
class EmbreeTracer {
 public:
  static constexpr int kPacket = 16;

  /// threads 0: all that the machine has.
  explicit EmbreeTracer(const TracedSet& set, int threads = 0);
  ~EmbreeTracer();
  EmbreeTracer(const EmbreeTracer&) = delete;
  EmbreeTracer& operator=(const EmbreeTracer&) = delete;

  /// Boxes and BVH of the particles as this frame's footprint filter widens them.
  void build(const TracedFrame& frame);
  /// What changes with the sensor's place: the particles' matrices and features.
  void prepare(const TracedFrame& frame);
  /// After both; results are resized to the rays.
  void trace(const TracedFrame& frame, const TracedRays& rays, TracedResults& results) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli::bench
