#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <new>
#include <string>
#include <utility>

#include "host/api/simuli.h"
#include "host/base/error.hpp"
#include "host/base/version.hpp"
#include "host/render/scene/simulator.hpp"
#include "io/log/lidar_file.hpp"
#include "io/scene/scene_folder.hpp"

struct simuli_device {
  simuli::Device device;
  std::string name;
};

struct simuli_scene {
  simuli::SceneFile file;  // without its scene, which the simulator has
  simuli::Simulator simulator;
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

[[noreturn]] void refuse_sensor(const char* kind, const std::string& name) {
  throw Error(ErrorKind::kUsage, fmt::format("name: found \"{}\", allowed a {} of the scene", name, kind));
}

const simuli::Trajectory& path_of(const simuli_scene& scene) {
  if (!scene.file.world_from_rig.poses().empty()) return scene.file.world_from_rig;
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
    simuli::Simulator simulator(on, std::move(file.scene));
    out = new simuli_scene{std::move(file), std::move(simulator)};
  });
}

void simuli_scene_close(simuli_scene* scene) { delete scene; }

size_t simuli_scene_sensor_count(const simuli_scene* scene) {
  return scene == nullptr ? 0 : scene->file.cameras.size() + scene->file.lidars.size();
}

simuli_status simuli_scene_sensor(const simuli_scene* scene, size_t index, simuli_sensor* sensor) {
  return guarded([&] {
    const auto& cameras = need(scene, "scene").file.cameras;
    const auto& lidars = scene->file.lidars;
    simuli_sensor& out = need(sensor, "sensor");
    if (index < cameras.size()) {
      const simuli::LogCamera& c = cameras[index];
      out = {c.model.name.c_str(),
             1,
             static_cast<std::size_t>(c.model.width),
             static_cast<std::size_t>(c.model.height),
             to_c(c.rig_from_camera)};
      return;
    }
    if (index - cameras.size() >= lidars.size()) {
      throw Error(
          ErrorKind::kUsage,
          fmt::format("index: found {}, allowed less than {}", index, cameras.size() + lidars.size()));
    }
    const simuli::LogLidar& l = lidars[index - cameras.size()];
    const std::size_t rows = row_count(l.model);
    out = {name_of(l.model).c_str(), 0, ray_count(l.model) / rows, rows, to_c(l.rig_from_lidar)};
  });
}

simuli_status simuli_scene_add_lidar(simuli_scene* scene,
                                     const char* name_or_file,
                                     const simuli_pose* rig_from_sensor) {
  return guarded([&] {
    const std::string what = &need(name_or_file, "name_or_file");
    const simuli::Pose mount = pose_of(need(rig_from_sensor, "rig_from_sensor"));
    simuli_scene& s = need(scene, "scene");
    std::error_code ignored;
    simuli::LidarModel model = std::filesystem::is_regular_file(what, ignored)
                                   ? simuli::read_lidar_file(what).model
                                   : simuli::LidarModel(simuli::builtin_lidar(what));
    if (s.file.find_camera(name_of(model)) != nullptr || s.file.find_lidar(name_of(model)) != nullptr) {
      throw Error(ErrorKind::kUsage,
                  fmt::format("name_or_file: found {}, which the scene has already", name_of(model)));
    }
    s.file.lidars.push_back({std::move(model), mount});
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
    const std::string sensor = &need(name, "name");
    const simuli::LogCamera* camera = scene->file.find_camera(sensor);
    const simuli::LogLidar* lidar = scene->file.find_lidar(sensor);
    if (camera == nullptr && lidar == nullptr) refuse_sensor("sensor", sensor);
    const simuli::Pose& mount = camera != nullptr ? camera->rig_from_camera : lidar->rig_from_lidar;
    const auto s = simuli::Shot::along(path, mount, time_start_s, time_end_s);
    need(shot, "shot") = {
        to_c(s.world_from_sensor_start), to_c(s.world_from_sensor_end), s.time_start_s, s.time_end_s};
  });
}

simuli_status simuli_render_camera(
    simuli_scene* scene, const char* name, const simuli_shot* shot, float* rgb, size_t values) {
  return guarded([&] {
    const std::string sensor = &need(name, "name");
    const simuli::LogCamera* camera = need(scene, "scene").file.find_camera(sensor);
    if (camera == nullptr) refuse_sensor("camera", sensor);
    const auto pixels =
        static_cast<std::size_t>(camera->model.width) * static_cast<std::size_t>(camera->model.height);
    need_length("values", values, 3 * pixels);
    const simuli::Image image = scene->simulator.render(camera->model, shot_of(need(shot, "shot")));
    std::copy(image.data.begin(), image.data.end(), &need(rgb, "rgb"));
  });
}

simuli_status simuli_render_lidar(simuli_scene* scene,
                                  const char* name,
                                  const simuli_shot* shot,
                                  const simuli_lidar_frame* frame) {
  return guarded([&] {
    const std::string sensor = &need(name, "name");
    const simuli::LogLidar* lidar = need(scene, "scene").file.find_lidar(sensor);
    if (lidar == nullptr) refuse_sensor("LiDAR", sensor);
    const simuli_lidar_frame& out = need(frame, "frame");
    need_length("rays", out.rays, ray_count(lidar->model));
    const simuli::Shot at = shot_of(need(shot, "shot"));
    const simuli::LidarFrame seen = scene->simulator.render(lidar->model, at);
    if (out.range_m != nullptr) std::copy(seen.range.begin(), seen.range.end(), out.range_m);
    if (out.intensity != nullptr) std::copy(seen.intensity.begin(), seen.intensity.end(), out.intensity);
    if (out.drop != nullptr) std::copy(seen.drop.begin(), seen.drop.end(), out.drop);
    if (out.points_m == nullptr) return;
    float* to = out.points_m;
    for (const Eigen::Vector3d& p : world_points(lidar->model, seen, at)) {
      for (int i = 0; i < 3; ++i) *to++ = static_cast<float>(p[i]);
    }
  });
}

}  // extern "C"
