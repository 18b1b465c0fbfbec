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

/// What a ray meets first.
struct StreetHit {
  bool hit = false;
  double range = 0.0;                                // m
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, world, towards the outside of the surface
  Eigen::Vector3d colour = Eigen::Vector3d::Zero();  // [0,1]; the sky's colour when nothing is hit
  double reflectance = 0.0;                          // [0,1], LiDAR; 0: glass, which returns nothing
  bool on_car = false;                               // the moving car
};

/// What a LiDAR measures along one ray.
struct StreetReturn {
  double range = 0.0;      // m from the ray's origin; 0: nothing came back
  double intensity = 0.0;  // [0,1]
};

/// How the street's moving car drives: straight ahead in its lane.
struct StreetCar {
  double start_m = 14.0;  // x of its middle at time 0
  double lane_m = 1.75;   // y; the rig drives at -1.75
  double speed_m_per_s = 4.0;
  /// Centre of its footprint on the road, world, m.
  [[nodiscard]] Eigen::Vector3d position(double time_s) const {
    return {start_m + speed_m_per_s * time_s, lane_m, 0.0};
  }
  /// The car as an actor, with a key pose every 0.1 s. The box fits tightly.
  [[nodiscard]] Actor actor(double start_s, double end_s) const;
};

/// How the street's person walks: straight across the road before the rig, swinging arms and legs.
struct StreetWalker {
  Eigen::Vector2d start_m{15.0, -3.0};  // of the middle of the feet at time 0, world
  double heading_rad = 1.9;             // where to, left of the world's x
  double speed_m_per_s = 1.3;
  double strides_per_s = 0.9;  // two steps each

  /// Where the middle of the feet is, x forward.
  [[nodiscard]] Pose world_from_walker(double time_s) const;
  /// The person as an actor, "pedestrian", with a key pose every 0.1 s. The box holds the whole stride.
  [[nodiscard]] Actor actor(double start_s, double end_s) const;
};

/// What rays are traced through.
class TracedWorld {
 public:
  TracedWorld() = default;
  TracedWorld(const TracedWorld&) = default;
  TracedWorld& operator=(const TracedWorld&) = default;
  virtual ~TracedWorld() = default;

  /// First hit of the ray from origin (world, m) along the unit direction at time_s, up to max_range.
  /// Non-finite rays hit nothing.
  [[nodiscard]] virtual StreetHit trace(const Eigen::Vector3d& origin,
                                        const Eigen::Vector3d& direction,
                                        double time_s,
                                        double max_range) const = 0;
  /// The same ray through a LiDAR: nothing for glass, for hits outside [range_min, range_max], and where
  /// reflectance * cos(incidence) / range^2 is below kMinimumEnergy. Deterministic.
  [[nodiscard]] StreetReturn lidar_return(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction,
                                          double time_s,
                                          double range_min,
                                          double range_max) const;
  static constexpr double kMinimumEnergy = 4e-6;  // 1/m^2; bare asphalt goes silent beyond about 40 m
};

/// What is on the street. Houses, trunks, lamps and parked cars stand where they do by the seed alone.
struct StreetContents {
  std::uint64_t seed = 1;  // varies textures and furniture
  std::optional<StreetCar> car = StreetCar{};
  bool thin_poles = false;  // 1.6 to 4 cm across, along both pavements
  std::optional<StreetWalker> walker = std::nullopt;
  const StreetDetail* detail = nullptr;  // beside what the plain street has; null: nothing
};

class Street : public TracedWorld {
 public:
  explicit Street(const StreetContents& contents = {});
  [[nodiscard]] StreetHit trace(const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction,
                                double time_s,
                                double max_range) const override;
  static constexpr double kLength_m = 260.0;  // the rig may drive from x = 0 to here

 private:
  StreetContents contents_;
  std::shared_ptr<const StreetWorld> world_;
};

struct StreetOptions {
  std::filesystem::path output;
  int frames = 20;             // images per camera = sweeps
  double speed_m_per_s = 8.0;  // of the rig
  double lane_shift_m = 0.0;   // the rig drives so far to its left; what it passes stays the same
  int image_width = 320;
  int image_height = 180;
  int lidar_columns = 900;
  bool moving_car = true;
  StreetCar car{};  // how it drives
  bool walking_person = false;
  StreetWalker walker{};         // how it walks
  bool rolling_shutter = false;  // 20 ms top to bottom instead of a global shutter
  std::uint64_t seed = 1;
  const StreetDetail* detail = nullptr;  // as StreetContents
  int threads = 0;                       // 0: one per core; the result is the same for any number

  [[nodiscard]] StreetContents contents() const;
};

/// Renders the street into a log folder (complete or not at all): camera "front", lidar "top", both at
/// 10 Hz, trajectory at 100 Hz, the moving car and the person actors with their true tracks. Sweep i spans
/// [0.1 i, 0.1 (i + 1)] s and image i is exposed about its middle. `progress(done, total)` is called after
/// every frame. Error{kInput} names an option outside its range, or an output folder that already exists.
Log synth_street(const StreetOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress = {});

/// The log that synth_street writes, without its pictures and sweeps. Same errors about options.
[[nodiscard]] Log street_log(const StreetOptions& options);

/// The picture a camera takes of the street: RGB in [0,1], mean of 2x2 rays per pixel (of those that the lens
/// has; black where it has none), each pixel at its own time between time_start_s and time_end_s. For views
/// that no log holds, too.
[[nodiscard]] Image render_street(const TracedWorld& street,
                                  const LogCamera& camera,
                                  const Trajectory& world_from_rig,
                                  double time_start_s,
                                  double time_end_s,
                                  int threads = 0);

/// The sweep a LiDAR takes of the street; each ray from its own origin at its own time.
[[nodiscard]] Sweep scan_street(const TracedWorld& street,
                                const LogLidar& lidar,
                                const Trajectory& world_from_rig,
                                double time_start_s,
                                double time_end_s,
                                int threads = 0);

}  // namespace simuli
