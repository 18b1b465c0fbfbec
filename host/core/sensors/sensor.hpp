#pragma once
// A sensor for rendering: model, mounting on the rig, and duration of a frame.
#include <cstddef>
#include <memory>
#include <string>

#include "host/core/base/pose.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"

namespace simuli {

/// A camera or a LiDAR on a rig. A handle: copies share immutable numbers that were validated at construction.
/// Caches use these numbers as key, so an equal sensor made again finds its cached data.
class Sensor {
 public:
  /// duration_s: read-out of a rolling shutter; 0: an instant. Throws Error{kInput} for a camera that
  /// validate() or need_name() rejects, or a duration that is negative or not finite.
  explicit Sensor(Camera camera, const Pose& rig_from_sensor = {}, double duration_s = 0.0);
  /// The duration is the model's sweep_s. Throws Error{kInput} for a LiDAR that validate() or need_name()
  /// rejects.
  explicit Sensor(LidarModel lidar, const Pose& rig_from_sensor = {});

  /// The model's name, unless changed by named(). Valid during the lifetime of any copy.
  [[nodiscard]] const std::string& name() const { return *name_; }
  [[nodiscard]] bool is_camera() const;
  /// Throws Error{kUsage} for the other kind of sensor.
  [[nodiscard]] const Camera& camera() const;
  [[nodiscard]] const LidarModel& lidar() const;
  [[nodiscard]] const Pose& rig_from_sensor() const { return rig_from_sensor_; }
  /// Seconds from a frame's start to its end.
  [[nodiscard]] double duration_s() const { return duration_s_; }

  /// Pixels of a picture; beams and firings of a sweep (a ray list is one row).
  [[nodiscard]] std::size_t rows() const;
  [[nodiscard]] std::size_t columns() const;
  [[nodiscard]] std::size_t ray_count() const { return rows() * columns(); }
  /// The rays of a LiDAR's frame, nominal or measured. Throws Error{kUsage} for a camera.
  [[nodiscard]] const LidarRays& rays() const;

  [[nodiscard]] Sensor named(std::string name) const;  // throws Error{kInput} for an invalid name
  [[nodiscard]] Sensor mounted(const Pose& rig_from_sensor) const;
  /// For a LiDAR the beams' time offsets become other shares of the sweep: throws Error{kInput} for 0.
  [[nodiscard]] Sensor with_duration(double duration_s) const;
  /// Returns the LiDAR with the rays of a recorded sweep (rows x columns). Throws Error{kInput} for another
  /// number of rays, Error{kUsage} for a camera.
  [[nodiscard]] Sensor with_rays(LidarRays rays) const;
  /// Returns the camera with pictures of another size. Throws Error{kUsage} for a LiDAR.
  [[nodiscard]] Sensor resized(int width, int height) const;

  /// Whether both have the same rays: equal models and measurements, ignoring name, mounting and a camera's
  /// duration. Equal sensors have equal hashes.
  [[nodiscard]] bool has_rays_of(const Sensor& other) const;
  [[nodiscard]] std::size_t rays_hash() const;

 private:
  struct Model;
  Sensor(std::shared_ptr<const Model> model,
         std::shared_ptr<const std::string> name,
         const Pose& rig_from_sensor,
         double duration_s);

  std::shared_ptr<const Model> model_;
  std::shared_ptr<const std::string> name_;
  Pose rig_from_sensor_;
  double duration_s_;
};

}  // namespace simuli
