#pragma once
// A street of any length with bends, hills, crossings and traffic. Its ground truth is as exact as that of the
// short street (io/synth/street.hpp), whose materials and furniture it uses.
//
// World: the rig starts at the origin towards +x, z up. Positions on the street are s, m along its centre line,
// and left_m beside it.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "io/synth/street.hpp"

namespace simuli {

/// Straight pieces of kPiece_m, each flat in its own frame, separated by the planes that bisect the angles
/// between them, where walls and kerbs join. A piece's solids are created when a ray first enters it.
class LongStreet : public TracedWorld {
 public:
  /// The centre line is drivable from s = 0 to length_m and continues beyond the range of LiDARs at both ends.
  /// The seed determines solids and bends.
  explicit LongStreet(double length_m, std::uint64_t seed = 1);
  ~LongStreet() override;
  LongStreet(const LongStreet&) = delete;
  LongStreet& operator=(const LongStreet&) = delete;

  /// Sets the moving cars, with the size of the street's own, by their tracks.
  void set_traffic(std::vector<Actor> cars);

  [[nodiscard]] StreetHit trace(const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction,
                                double time_s,
                                double max_range) const override;

  /// Returns a pose on the road, x along it, y to its left, smooth between pieces. Defined from kMargin_m
  /// before s = 0 to kMargin_m beyond the length.
  [[nodiscard]] Pose world_from_street(double s_m, double left_m) const;

  /// Frees the solids of pieces farther than distance_m along the street; they are recreated identically on
  /// demand. Must not run while rays are traced.
  void forget_beyond(double s_m, double distance_m);
  /// Returns the number of pieces with solids in memory.
  [[nodiscard]] std::size_t pieces_held() const;
  [[nodiscard]] std::size_t pieces() const;

  static constexpr double kPiece_m = 20.0;
  static constexpr double kMargin_m = 110.0;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct LongStreetOptions {
  std::filesystem::path output;
  double length_m = 2000.0;   // driven length
  int frames = 2000;          // images per camera = sweeps per LiDAR, at 10 Hz
  int cameras = 3;            // 1 to 4: front, left, right, rear
  int lidars = 2;             // 1 to 3: top, front_low, rear_low
  double lane_shift_m = 0.0;  // offset of the rig to its left; other objects are unchanged
  int image_width = 320;
  int image_height = 180;
  int lidar_columns = 900;
  bool traffic = true;
  bool rolling_shutter = false;  // 20 ms from top to bottom instead of a global shutter
  std::uint64_t seed = 1;
  int threads = 0;  // 0: one per core; the result does not depend on it
};

/// synth_street() for the long street. Memory grows with the length only by poses and names.
Log synth_long_street(const LongStreetOptions& options,
                      const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Returns the log of synth_long_street() without pictures and sweeps. Errors as for its options.
[[nodiscard]] Log long_street_log(const LongStreetOptions& options);

}  // namespace simuli
