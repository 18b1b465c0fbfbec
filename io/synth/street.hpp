#pragma once
// The embedded synthetic street: an analytic world of planes, boxes, cylinders and spheres with procedural
// colour, ray traced in double precision. Ground truth for range, colour, intensity and drops.
//
// World: x along the street (the rig drives towards +x, from x = 0), y to the left, z up, road at z = 0.
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "io/log/log.hpp"
#include "io/picture/image.hpp"

namespace simuli {

struct StreetDetail;
struct StreetWorld;

/// First intersection of a ray.
struct StreetHit {
  bool hit = false;
  double range = 0.0;                                // m
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, world, outward
  Eigen::Vector3d colour = Eigen::Vector3d::Zero();  // [0,1]; the sky's colour without an intersection
  double reflectance = 0.0;                          // [0,1], for LiDAR; 0: glass, which returns nothing
  bool on_car = false;                               // whether it is the moving car
};

/// Measurement of a LiDAR along one ray.
struct StreetReturn {
  double range = 0.0;      // m from the ray's origin; 0: no return
  double intensity = 0.0;  // [0,1]
};

/// Motion of the street's car: straight ahead in its lane.
struct StreetCar {
  double start_m = 14.0;  // x of its centre at time 0
  double lane_m = 1.75;   // y; the rig's lane is at -1.75
  double speed_m_per_s = 4.0;
  /// Returns the centre of its footprint on the road, world, m.
  [[nodiscard]] Eigen::Vector3d position(double time_s) const {
    return {start_m + speed_m_per_s * time_s, lane_m, 0.0};
  }
  /// Returns the car as an actor with a key pose every 0.1 s. The box fits tightly.
  [[nodiscard]] Actor actor(double start_s, double end_s) const;
};

/// Motion of the street's person: straight across the road in front of the rig, swinging arms and legs.
struct StreetWalker {
  Eigen::Vector2d start_m{15.0, -3.0};  // midpoint between the feet at time 0, world
  double heading_rad = 1.9;             // direction, left of the world's x
  double speed_m_per_s = 1.3;
  double strides_per_s = 0.9;  // of two steps each

  /// Returns the pose of the midpoint between the feet, x forward.
  [[nodiscard]] Pose world_from_walker(double time_s) const;
  /// Returns the person as an actor "pedestrian" with a key pose every 0.1 s. The box contains the whole
  /// stride.
  [[nodiscard]] Actor actor(double start_s, double end_s) const;
};

/// A world that rays are traced through.
class TracedWorld {
 public:
  TracedWorld() = default;
  TracedWorld(const TracedWorld&) = default;
  TracedWorld& operator=(const TracedWorld&) = default;
  virtual ~TracedWorld() = default;

  /// Returns the first intersection of the ray from origin (world, m) along the unit direction at time_s, up to
  /// max_range. Non-finite rays have none.
  [[nodiscard]] virtual StreetHit trace(const Eigen::Vector3d& origin,
                                        const Eigen::Vector3d& direction,
                                        double time_s,
                                        double max_range) const = 0;
  /// Returns the LiDAR measurement of the ray: no return for glass, for hits outside [range_min, range_max],
  /// and if reflectance * cos(incidence) / range^2 is below kMinimumEnergy. Deterministic.
  [[nodiscard]] StreetReturn lidar_return(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction,
                                          double time_s,
                                          double range_min,
                                          double range_max) const;
  static constexpr double kMinimumEnergy = 4e-6;  // 1/m^2; bare asphalt does not return beyond about 40 m
};

/// Content of the street. The seed alone determines houses, trunks, lamps and parked cars.
struct StreetContents {
  std::uint64_t seed = 1;  // varies textures and furniture
  std::optional<StreetCar> car = StreetCar{};
  bool thin_poles = false;  // 1.6 to 4 cm wide, along both pavements
  std::optional<StreetWalker> walker = std::nullopt;
  const StreetDetail* detail = nullptr;  // in addition to the plain street; null: none
};

class Street : public TracedWorld {
 public:
  explicit Street(const StreetContents& contents = {});
  [[nodiscard]] StreetHit trace(const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction,
                                double time_s,
                                double max_range) const override;
  static constexpr double kLength_m = 260.0;  // drivable from x = 0 to this x

 private:
  StreetContents contents_;
  std::shared_ptr<const StreetWorld> world_;
};

struct StreetOptions {
  std::filesystem::path output;
  int frames = 20;             // images per camera = sweeps
  double speed_m_per_s = 8.0;  // of the rig
  double lane_shift_m = 0.0;   // offset of the rig to its left; other objects are unchanged
  int image_width = 320;
  int image_height = 180;
  int lidar_columns = 900;
  bool moving_car = true;
  StreetCar car{};  // motion
  bool walking_person = false;
  StreetWalker walker{};         // motion
  bool rolling_shutter = false;  // 20 ms from top to bottom instead of a global shutter
  std::uint64_t seed = 1;
  const StreetDetail* detail = nullptr;  // as StreetContents
  int threads = 0;                       // 0: one per core; the result does not depend on it

  [[nodiscard]] StreetContents contents() const;
};

/// Renders the street into a log folder (atomically): camera "front" and LiDAR "top" at 10 Hz, trajectory at
/// 100 Hz, the moving car and the person as actors with exact tracks. Sweep i spans [0.1 i, 0.1 (i + 1)] s, and
/// image i is exposed around its middle. Calls `progress(done, total)` after every frame. Throws Error{kInput}
/// naming an option out of range, and for an existing output folder.
Log synth_street(const StreetOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Returns the log of synth_street() without pictures and sweeps. Errors as for its options.
[[nodiscard]] Log street_log(const StreetOptions& options);

/// Renders a camera's picture of the street: RGB in [0,1], mean of 2x2 rays per pixel (those within the lens's
/// domain; black without any), each pixel at its own time between time_start_s and time_end_s. Also for poses
/// outside any log.
[[nodiscard]] Image render_street(const TracedWorld& street,
                                  const LogCamera& camera,
                                  const Trajectory& world_from_rig,
                                  double time_start_s,
                                  double time_end_s,
                                  int threads = 0);

/// Simulates a LiDAR's sweep of the street, with each ray's own origin and time.
[[nodiscard]] Sweep scan_street(const TracedWorld& street,
                                const LogLidar& lidar,
                                const Trajectory& world_from_rig,
                                double time_start_s,
                                double time_end_s,
                                int threads = 0);

}  // namespace simuli
