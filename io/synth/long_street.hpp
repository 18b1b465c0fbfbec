#pragma once
// A street of any length with bends, hills, crossings and traffic, made of pieces: the truth is as exact as
// the short street's (io/synth/street.hpp), whose materials and furniture it has.
//
// World: the rig drives from the origin towards +x at first, z up. Places on the street are s, m along its
// middle, and left_m beside it.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "io/synth/street.hpp"

namespace simuli {

/// Straight pieces of kPiece_m, each flat in a frame of its own, parted by the planes that halve the angles
/// between them: walls and kerbs meet there. A piece's solids are made when a ray first comes there.
class LongStreet : public TracedWorld {
 public:
  /// Its middle is drivable from s = 0 to length_m, and goes on so far at both ends that nothing ends in
  /// sight of a LiDAR. The seed decides what stands where, and where it bends.
  explicit LongStreet(double length_m, std::uint64_t seed = 1);
  ~LongStreet() override;
  LongStreet(const LongStreet&) = delete;
  LongStreet& operator=(const LongStreet&) = delete;

  /// What drives: cars with the size of the street's own, by their tracks and nowhere else.
  void set_traffic(std::vector<Actor> cars);

  [[nodiscard]] StreetHit trace(const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction,
                                double time_s,
                                double max_range) const override;

  /// On the road, x along it, y to its left: between pieces smooth, so that what drives there turns and does
  /// not jump. From kMargin_m before s = 0 to kMargin_m behind the length.
  [[nodiscard]] Pose world_from_street(double s_m, double left_m) const;

  /// Forgets the solids of pieces farther than distance_m along the street; whoever comes there makes the
  /// same again. While no ray is traced.
  void forget_beyond(double s_m, double distance_m);
  /// Pieces whose solids are there now.
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
  double length_m = 2000.0;   // that the rig drives, all of it
  int frames = 2000;          // images per camera = sweeps per LiDAR, at 10 Hz
  int cameras = 3;            // 1 to 4: front, left, right, rear
  int lidars = 2;             // 1 to 3: top, front_low, rear_low
  double lane_shift_m = 0.0;  // the rig drives so far to its left; what it passes stays the same
  int image_width = 320;
  int image_height = 180;
  int lidar_columns = 900;
  bool traffic = true;
  bool rolling_shutter = false;  // 20 ms top to bottom instead of a global shutter
  std::uint64_t seed = 1;
  int threads = 0;  // 0: one per core; the result is the same for any number
};

/// As synth_street(), with the long street. Memory does not grow with its length but for poses and names.
Log synth_long_street(const LongStreetOptions& options,
                      const std::function<void(std::size_t, std::size_t)>& progress = {});

/// The log that synth_long_street writes, without its pictures and sweeps. Same errors about options.
[[nodiscard]] Log long_street_log(const LongStreetOptions& options);

}  // namespace simuli
