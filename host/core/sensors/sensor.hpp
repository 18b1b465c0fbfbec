#pragma once
// A sensor to render with: what it is, where it sits on the rig, how long it takes for a frame.
#include <cstddef>
#include <memory>
#include <string>

#include "host/core/base/pose.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"

namespace simuli {

/// A camera or a LiDAR on a rig. A handle: copies are cheap and share numbers that were checked once, when
/// the sensor was made, and that never change. What is kept of a sensor is found again by these numbers, so
/// that an equal sensor that is made anew finds it, too.
class Sensor {
 public:
  /// duration_s: of a rolling shutter's read-out; 0: an instant. Error{kInput} for a camera that validate()
  /// or need_name() refuses, or a duration that is negative or not finite.
  explicit Sensor(Camera camera, const Pose& rig_from_sensor = {}, double duration_s = 0.0);
  /// A frame takes what the model says (sweep_s). Error{kInput} for a LiDAR that validate() or need_name() refuses.
  explicit Sensor(LidarModel lidar, const Pose& rig_from_sensor = {});

  /// The model's, unless named() says otherwise. Lives as long as any copy.
  [[nodiscard]] const std::string& name() const { return *name_; }
  [[nodiscard]] bool is_camera() const;
  /// Error{kUsage} of a sensor of the other kind.
  [[nodiscard]] const Camera& camera() const;
  [[nodiscard]] const LidarModel& lidar() const;
  [[nodiscard]] const Pose& rig_from_sensor() const { return rig_from_sensor_; }
  /// Seconds from a frame's start to its end.
  [[nodiscard]] double duration_s() const { return duration_s_; }

  /// Pixels of a picture; beams and firings of a sweep (a ray list is one row).
  [[nodiscard]] std::size_t rows() const;
  [[nodiscard]] std::size_t columns() const;
  [[nodiscard]] std::size_t ray_count() const { return rows() * columns(); }
  /// The rays of a LiDAR's frame: as its model has them, or as measured. Error{kUsage} of a camera.
  [[nodiscard]] const LidarRays& rays() const;

  [[nodiscard]] Sensor named(std::string name) const;  // Error{kInput} for what is no name
  [[nodiscard]] Sensor mounted(const Pose& rig_from_sensor) const;
  /// Of a LiDAR, whose beams then fire at other shares of the turn: Error{kInput} for 0.
  [[nodiscard]] Sensor with_duration(double duration_s) const;
  /// The LiDAR with the rays of one recorded sweep (rows x columns) instead of its model's. Error{kInput} for
  /// another number of rays, Error{kUsage} of a camera.
  [[nodiscard]] Sensor with_rays(LidarRays rays) const;
  /// The camera with pictures of another size. Error{kUsage} of a LiDAR.
  [[nodiscard]] Sensor resized(int width, int height) const;

  /// Whether both have the same rays: equal models, equal measurements. Name, mounting and a camera's
  /// duration don't count. Equal sensors have equal hashes.
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
