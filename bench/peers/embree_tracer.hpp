#pragma once
// Reference of `simuli bench --peers`: ray tracing of the same particles with Embree. It shares no code with
// the kernels and no header with Eigen, since it is compiled for the host processor.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cl/shared/sensor_constants.h"

namespace simuli::bench {

/// Particles of one set by parameter, as GaussianSet::params: values[param_rows][count].
struct TracedSet {
  std::span<const float> values;
  std::size_t count = 0;
  int sh_degree = 0;
  int clamped_channels = 3;  // features with bias 1/2 that are not negative: 3 colours, or the intensity
};

/// One frame of a sensor.
struct TracedFrame {
  shared::SensorConstants<double> constants;  // poses, footprint, cuts, background
  bool moving = false;
};

/// Rays in the sensor frame, by packet; rays with a zero direction are not traced. Each array has a length
/// [count] that is a multiple of EmbreeTracer::kPacket.
struct TracedRays {
  std::vector<float> direction[3];  // unit
  std::vector<float> origin[3];     // m; empty: all rays start at the sensor's origin
  std::vector<float> time;          // share of the frame
};

/// Results of the rays, as RayResults.
struct TracedResults {
  std::vector<float> feature[3];
  std::vector<float> transmittance;
  std::vector<float> distance;  // sum of w tau, m
  std::vector<float> median;    // m; 0 if the transmittance remains above 1/2
};

/// Each particle is a primitive of a user geometry with the box of the ellipsoid at which its alpha reaches
/// the cut. Packets of rays gather the nearest kWindow responses behind those of the last round, blend them,
/// and continue until the transmittance cut. Two particles at the same float distance count once if a round
/// ends between them.
class EmbreeTracer {
 public:
  static constexpr int kPacket = 16;

  /// threads 0: all threads of the machine.
  explicit EmbreeTracer(const TracedSet& set, int threads = 0);
  ~EmbreeTracer();
  EmbreeTracer(const EmbreeTracer&) = delete;
  EmbreeTracer& operator=(const EmbreeTracer&) = delete;

  /// Builds boxes and BVH of the particles with the footprint filter of this frame.
  void build(const TracedFrame& frame);
  /// Computes the matrices and features that depend on the sensor position.
  void prepare(const TracedFrame& frame);
  /// Traces after build() and prepare(); results are resized to the rays.
  void trace(const TracedFrame& frame, const TracedRays& rays, TracedResults& results) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli::bench
