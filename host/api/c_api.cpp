#include <algorithm>
#include <cmath>
#include <exception>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "host/api/simuli.h"
#include "host/base/error.hpp"
#include "host/base/version.hpp"
#include "host/render/scene/scene_on_device.hpp"
#include "io/scene/sensor_rig.hpp"

struct simuli_device {
  simuli::Device device;
  std::string name;
};

struct simuli_scene {
  simuli::SensorRig rig;
  simuli::Trajectory world_from_rig;
  simuli::SceneOnDevice on_device;
};

namespace {

using simuli::Error;
using simuli::ErrorKind;

thread_local std::string last_error;

/// Runs f; nothing leaves it but a status.
template <class F>
simuli_status guarded(F&& f) noexcept {
  const auto fail = [](simuli_status status, const char* what) {
    try {
      last_error = what;
    } catch (...) {
      last_error.clear();
    }
    return status;
  };
  try {
    f();
    return SIMULI_OK;
  } catch (const Error& error) {
    return fail(static_cast<simuli_status>(error.exit_code()), error.what());
  } catch (const std::bad_alloc&) {
    return fail(SIMULI_INTERNAL, "out of memory");
  } catch (const std::exception& error) {
    return fail(SIMULI_INTERNAL, error.what());
  } catch (...) {
    return fail(SIMULI_INTERNAL, "an unknown exception");
  }
}

template <class T>
T& need(T* pointer, const char* argument) {
  if (pointer == nullptr) throw Error(ErrorKind::kUsage, fmt::format("{}: found NULL", argument));
  return *pointer;
}

void need_length(const char* argument, std::size_t found, std::size_t allowed) {
  if (found == allowed) return;
  throw Error(ErrorKind::kUsage, fmt::format("{}: found {}, allowed {}", argument, found, allowed));
}

simuli::Pose pose_of(const simuli_pose& p) {
  const Eigen::Quaterniond q(p.rotation_wxyz[0], p.rotation_wxyz[1], p.rotation_wxyz[2], p.rotation_wxyz[3]);
  const Eigen::Vector3d position(p.position_m);
  const double norm = q.norm();
  if (!(norm > 0.0) || !std::isfinite(norm) || !position.allFinite()) {
    throw Error(ErrorKind::kUsage, "pose: found a zero quaternion or a number that is not finite");
  }
  return {q.normalized(), position};
}

simuli_pose to_c(const simuli::Pose& p) {
  const Eigen::Quaterniond& q = p.rotation;
  const Eigen::Vector3d& t = p.translation;
  return {{t.x(), t.y(), t.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

simuli::Shot shot_of(const simuli_shot& s) {
  if (!(s.time_end_s >= s.time_start_s) || !std::isfinite(s.time_end_s) || !std::isfinite(s.time_start_s)) {
    throw Error(ErrorKind::kUsage, "shot: found an end before its start, or a time that is not finite");
  }
  return {pose_of(s.world_from_sensor_start), pose_of(s.world_from_sensor_end), s.time_start_s, s.time_end_s};
}

/// A sensor of the scene, those that were added among them.
simuli::Sensor sensor_of(const simuli_scene& scene, const char* name) {
  const std::string wanted = &need(name, "name");
  if (scene.rig.has(wanted)) return scene.rig.find(wanted);
  std::vector<std::string> known;
  for (const simuli::Sensor& sensor : scene.rig.sensors()) known.push_back(sensor.name());
  throw Error(ErrorKind::kUsage,
              fmt::format("name: found \"{}\", allowed {}", wanted, fmt::join(known, ", ")));
}

const simuli::Trajectory& path_of(const simuli_scene& scene) {
  if (!scene.world_from_rig.poses().empty()) return scene.world_from_rig;
  throw Error(ErrorKind::kInput, "scene: found no recorded path");
}

}  // namespace

extern "C" {

const char* simuli_version(void) { return simuli::version(); }

const char* simuli_error(void) { return last_error.c_str(); }

simuli_status simuli_device_open(const char* request, simuli_device** device) {
  return guarded([&] {
    simuli_device*& out = need(device, "device");
    simuli::Device opened = simuli::Device::best(request == nullptr ? "" : request);
    std::string name = opened.info().label();
    out = new simuli_device{std::move(opened), std::move(name)};
  });
}

const char* simuli_device_name(const simuli_device* device) {
  return device == nullptr ? "" : device->name.c_str();
}

void simuli_device_close(simuli_device* device) { delete device; }

simuli_status simuli_scene_open(const simuli_device* device, const char* folder, simuli_scene** scene) {
  return guarded([&] {
    const simuli::Device& on = need(device, "device").device;
    simuli_scene*& out = need(scene, "scene");
    simuli::SceneFile file = simuli::read_scene(&need(folder, "folder"));
    simuli::SensorRig rig(file);
    simuli::SceneOnDevice on_device(on, std::move(file.scene));
    out = new simuli_scene{std::move(rig), std::move(file.world_from_rig), std::move(on_device)};
  });
}

void simuli_scene_close(simuli_scene* scene) { delete scene; }

size_t simuli_scene_sensor_count(const simuli_scene* scene) {
  return scene == nullptr ? 0 : scene->rig.sensors().size();
}

simuli_status simuli_scene_sensor(const simuli_scene* scene, size_t index, simuli_sensor* sensor) {
  return guarded([&] {
    const std::vector<simuli::Sensor>& sensors = need(scene, "scene").rig.sensors();
    simuli_sensor& out = need(sensor, "sensor");
    if (index >= sensors.size()) {
      throw Error(ErrorKind::kUsage,
                  fmt::format("index: found {}, allowed less than {}", index, sensors.size()));
    }
    const simuli::Sensor& found = sensors[index];
    out = {found.name().c_str(),
           found.is_camera() ? 1 : 0,
           found.columns(),
           found.rows(),
           to_c(found.rig_from_sensor())};
  });
}

simuli_status simuli_scene_add_lidar(simuli_scene* scene,
                                     const char* name_or_file,
                                     const simuli_pose* rig_from_sensor) {
  return guarded([&] {
    const std::string what = &need(name_or_file, "name_or_file");
    const simuli::Pose mount = pose_of(need(rig_from_sensor, "rig_from_sensor"));
    simuli_scene& s = need(scene, "scene");
    const simuli::Sensor sensor = simuli::named_sensor(what).mounted(mount);
    (void)sensor.lidar();  // no camera
    s.rig.add(sensor);
  });
}

simuli_status simuli_scene_span(const simuli_scene* scene, double* start_s, double* end_s) {
  return guarded([&] {
    const simuli::Trajectory& path = path_of(need(scene, "scene"));
    need(start_s, "start_s") = path.start_s();
    need(end_s, "end_s") = path.end_s();
  });
}

simuli_status simuli_scene_shot(
    const simuli_scene* scene, const char* name, double time_start_s, double time_end_s, simuli_shot* shot) {
  return guarded([&] {
    const simuli::Trajectory& path = path_of(need(scene, "scene"));
    const simuli::Sensor sensor = sensor_of(*scene, name);
    const auto s = simuli::Shot::along(path, sensor.rig_from_sensor(), time_start_s, time_end_s);
    need(shot, "shot") = {
        to_c(s.world_from_sensor_start), to_c(s.world_from_sensor_end), s.time_start_s, s.time_end_s};
  });
}

simuli_status simuli_render_camera(
    simuli_scene* scene, const char* name, const simuli_shot* shot, float* rgb, size_t values) {
  return guarded([&] {
    const simuli::Sensor camera = sensor_of(need(scene, "scene"), name);
    (void)camera.camera();  // no LiDAR
    need_length("values", values, 3 * camera.ray_count());
    const simuli::Image image = scene->on_device.render(camera, shot_of(need(shot, "shot"))).image();
    std::copy(image.data.begin(), image.data.end(), &need(rgb, "rgb"));
  });
}

simuli_status simuli_render_lidar(simuli_scene* scene,
                                  const char* name,
                                  const simuli_shot* shot,
                                  const simuli_lidar_frame* frame) {
  return guarded([&] {
    const simuli::Sensor lidar = sensor_of(need(scene, "scene"), name);
    (void)lidar.lidar();  // no camera
    const simuli_lidar_frame& out = need(frame, "frame");
    need_length("rays", out.rays, lidar.ray_count());
    const simuli::Frame rendered = scene->on_device.render(lidar, shot_of(need(shot, "shot")));
    const simuli::LidarFrame seen = rendered.lidar();
    if (out.range_m != nullptr) std::copy(seen.range.begin(), seen.range.end(), out.range_m);
    if (out.intensity != nullptr) std::copy(seen.intensity.begin(), seen.intensity.end(), out.intensity);
    if (out.drop != nullptr) std::copy(seen.drop.begin(), seen.drop.end(), out.drop);
    if (out.points_m == nullptr) return;
    float* to = out.points_m;
    for (const Eigen::Vector3d& p : rendered.points()) {
      for (int i = 0; i < 3; ++i) *to++ = static_cast<float>(p[i]);
    }
  });
}

}  // extern "C"
