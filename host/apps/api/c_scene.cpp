// C API of scenes, sensors and actors.
#include "host/apps/api/c_handles.hpp"
#include "host/core/scene/occluders.hpp"
#include "host/device/render/options/quality.hpp"
#include "io/splat/ply.hpp"

using namespace simuli;
using namespace simuli::capi;

namespace {

const Trajectory& path_of(const simuli_scene& scene) {
  if (!scene.file.world_from_rig.poses().empty()) return scene.file.world_from_rig;
  throw Error(ErrorKind::kInput, "scene: found no trajectory");
}

const Actor& actor_of(const simuli_scene& scene, std::size_t index) {
  const std::vector<Actor>& actors = scene.on_device.scene().actors;
  if (index < actors.size()) return actors[index];
  throw Error(ErrorKind::kUsage, fmt::format("index: found {}, allowed less than {}", index, actors.size()));
}

/// Changes the scene for all later frames.
template <class F>
void change(simuli_scene& scene, F&& f) {
  Scene changed = scene.on_device.scene();
  f(changed);
  scene.labels.reset();
  scene.on_device.set_scene(std::move(changed));
}

void add(simuli_scene* scene, const Sensor& sensor, const simuli_pose* mount) {
  need(scene, "scene").rig.add(sensor.mounted(pose_of(need(mount, "rig_from_sensor"))));
}

GaussianSet& set_of(Scene& scene, int is_lidar) { return is_lidar != 0 ? scene.lidar : scene.camera; }

}  // namespace

extern "C" {

simuli_status simuli_scene_open(const simuli_device* device, const char* folder, simuli_scene** scene) {
  return guarded([&] {
    const Device& on = need(device, "device").device;
    simuli_scene*& out = need(scene, "scene");
    SceneFile file = read_scene(&need(folder, "folder"));
    SensorRig rig(file);
    SceneOnDevice on_device(on, std::exchange(file.scene, {}));
    std::string notes = fmt::format("{}", fmt::join(file.splats.notes(), "\n"));
    out = new simuli_scene{
        std::move(rig), std::move(file), {}, std::move(on_device), {}, {}, {}, std::move(notes)};
  });
}

simuli_status simuli_scene_save(const simuli_scene* scene, const char* folder) {
  return guarded([&] {
    SceneFile file = need(scene, "scene").file;
    file.scene = scene->on_device.scene();
    write_scene(&need(folder, "folder"), file);
  });
}

void simuli_scene_close(simuli_scene* scene) { delete scene; }

size_t simuli_scene_left_out(const simuli_scene* scene) {
  return scene == nullptr ? 0 : static_cast<size_t>(scene->file.splats.left_out);
}

const char* simuli_scene_notes(const simuli_scene* scene) {
  return scene == nullptr ? "" : scene->notes.c_str();
}

simuli_status simuli_scene_set_options(simuli_scene* scene, const simuli_options* options) {
  return guarded([&] {
    need(scene, "scene").options = render_options(capi::quality_of(options), capi::settings_of(options));
    scene->labels.reset();
  });
}

size_t simuli_scene_sensor_count(const simuli_scene* scene) {
  return scene == nullptr ? 0 : scene->rig.sensors().size();
}

simuli_status simuli_scene_sensor(const simuli_scene* scene, size_t index, simuli_sensor* sensor) {
  return guarded([&] {
    const std::vector<Sensor>& sensors = need(scene, "scene").rig.sensors();
    simuli_sensor& out = need(sensor, "sensor");
    if (index >= sensors.size()) {
      throw Error(ErrorKind::kUsage,
                  fmt::format("index: found {}, allowed less than {}", index, sensors.size()));
    }
    const Sensor& found = sensors[index];
    out = {found.name().c_str(),
           found.is_camera() ? 1 : 0,
           found.columns(),
           found.rows(),
           to_c(found.rig_from_sensor()),
           found.duration_s()};
  });
}

simuli_status simuli_scene_add_sensor(simuli_scene* scene,
                                      const char* name_or_file,
                                      const char* as,
                                      const simuli_pose* rig_from_sensor) {
  return guarded([&] {
    const Sensor sensor = named_sensor(&need(name_or_file, "name_or_file"));
    add(scene, as == nullptr ? sensor : sensor.named(as), rig_from_sensor);
  });
}

simuli_status simuli_scene_add_camera(simuli_scene* scene,
                                      const simuli_camera* camera,
                                      const simuli_pose* rig_from_camera) {
  return guarded([&] {
    const simuli_camera& from = need(camera, "camera");
    Camera model{
        &need(from.name, "camera.name"), from.width, from.height, from.fx, from.fy, from.cx, from.cy};
    const std::string& name = model.name;
    if (from.shutter != nullptr)
      model.shutter = shutter_from_string(from.shutter, "camera " + name, "shutter");
    if (from.lens != nullptr) {
      std::vector<double> parameters;
      for (std::size_t i = 0; i < from.lens_parameter_count; ++i) {
        parameters.push_back((&need(from.lens_parameters, "camera.lens_parameters"))[i]);
      }
      const LensKind kind = lens_from_string(from.lens, "camera " + name, "lens");
      model.lens = Lens(kind, parameters, "camera " + name);
    }
    add(scene, Sensor(std::move(model), {}, from.duration_s), rig_from_camera);
  });
}

simuli_status simuli_scene_add_lidar(simuli_scene* scene,
                                     const simuli_lidar* lidar,
                                     const simuli_pose* rig_from_lidar) {
  return guarded([&] {
    const simuli_lidar& from = need(lidar, "lidar");
    Lidar model;
    model.name = &need(from.name, "lidar.name");
    for (std::size_t i = 0; i < from.row_count; ++i) {
      const simuli_lidar_row& row = (&need(from.rows, "lidar.rows"))[i];
      model.rows.push_back({row.elevation,
                            row.azimuth_offset,
                            row.vertical_offset,
                            row.horizontal_offset,
                            row.time_offset,
                            row.radial_offset});
    }
    model.columns = from.columns;
    model.azimuth_first = from.azimuth_first;
    model.azimuth_span = from.azimuth_span;
    model.spin = from.is_clockwise != 0 ? SpinDirection::kClockwise : SpinDirection::kCounterClockwise;
    model.sweep_s = from.sweep_s;
    model.range_min = from.range_min;
    model.range_max = from.range_max;
    model.beam_divergence = from.beam_divergence;
    add(scene, Sensor(LidarModel(std::move(model))), rig_from_lidar);
  });
}

simuli_status simuli_scene_span(const simuli_scene* scene, double* start_s, double* end_s) {
  return guarded([&] {
    const Trajectory& path = path_of(need(scene, "scene"));
    need(start_s, "start_s") = path.start_s();
    need(end_s, "end_s") = path.end_s();
  });
}

simuli_status simuli_scene_shot(
    const simuli_scene* scene, const char* name, double time_start_s, double time_end_s, simuli_shot* shot) {
  return guarded([&] {
    const Trajectory& path = path_of(need(scene, "scene"));
    const Sensor sensor = sensor_of(*scene, name);
    const auto s = Shot::along(path, sensor.rig_from_sensor(), time_start_s, time_end_s);
    need(shot, "shot") = {
        to_c(s.world_from_sensor_start), to_c(s.world_from_sensor_end), s.time_start_s, s.time_end_s};
  });
}

size_t simuli_scene_actor_count(const simuli_scene* scene) {
  return scene == nullptr ? 0 : scene->on_device.scene().actors.size();
}

simuli_status simuli_scene_actor(const simuli_scene* scene, size_t index, simuli_actor* actor) {
  return guarded([&] {
    const Actor& found = actor_of(need(scene, "scene"), index);
    const Eigen::Vector3d& size = found.size_m;
    need(actor, "actor") = {
        found.name.c_str(), found.kind.c_str(), {size.x(), size.y(), size.z()}, found.track.size()};
  });
}

simuli_status simuli_scene_actor_track(
    const simuli_scene* scene, size_t index, double* times_s, simuli_pose* world_from_actor, size_t count) {
  return guarded([&] {
    const Actor& found = actor_of(need(scene, "scene"), index);
    need_length("count", count, found.track.size());
    for (std::size_t i = 0; i < count; ++i) {
      (&need(times_s, "times_s"))[i] = found.track[i].time_s;
      (&need(world_from_actor, "world_from_actor"))[i] = to_c(found.track[i].corrected());
    }
  });
}

simuli_status simuli_scene_edit(simuli_scene* scene, const simuli_edit* edit) {
  return guarded([&] {
    const simuli_edit& wanted = need(edit, "edit");
    if (wanted.kind == SIMULI_DUPLICATE) {
      const std::string name = &need(wanted.new_name, "new_name");
      const std::string actor = &need(wanted.actor, "actor");
      change(need(scene, "scene"), [&](Scene& s) { duplicate_actor(s, actor, name); });
      add_copy(scene->copies, actor, name);
      return;
    }
    const ActorEdit one = edit_of(wanted);
    change(need(scene, "scene"), [&](Scene& s) { edit_actor(s, one); });
    if (wanted.kind == SIMULI_REMOVE) scene->copies.erase(one.actor);
  });
}

simuli_status simuli_scene_add_actor(simuli_scene* scene,
                                     const simuli_scene* other,
                                     const char* actor,
                                     const char* new_name) {
  return guarded([&] {
    const std::string name = &need(actor, "actor"), as = &need(new_name, "new_name");
    const Scene& from = need(other, "other").on_device.scene();
    change(need(scene, "scene"), [&](Scene& s) { add_actor(s, from, name, as); });
  });
}

simuli_status simuli_scene_particles(
    const simuli_scene* scene, int is_lidar, size_t* rows, size_t* columns, float* values, size_t count) {
  return guarded([&] {
    const Scene& s = need(scene, "scene").on_device.scene();
    const Eigen::MatrixXf& params = is_lidar != 0 ? s.lidar.params : s.camera.params;
    if (rows != nullptr) *rows = static_cast<std::size_t>(params.rows());
    if (columns != nullptr) *columns = static_cast<std::size_t>(params.cols());
    if (values == nullptr) return;
    need_length("count", count, static_cast<std::size_t>(params.size()));
    std::copy(params.data(), params.data() + params.size(), values);
  });
}

simuli_status simuli_scene_set_particles(
    simuli_scene* scene, int is_lidar, size_t rows, const float* values, size_t count) {
  return guarded([&] {
    change(need(scene, "scene"), [&](Scene& s) {
      GaussianSet& set = set_of(s, is_lidar);
      need_length("count", count, rows * static_cast<std::size_t>(set.params.cols()));
      const auto n = static_cast<Eigen::Index>(rows);
      if (has_particles_of_actors(s, set)) {
        need_length("rows", rows, static_cast<std::size_t>(set.params.rows()));
      } else if (n != set.params.rows()) {
        set.actor.clear();  // disoccluded Gaussians are removed
      }
      if (n == 0) throw Error(ErrorKind::kUsage, "rows: found 0, allowed at least 1");
      set.params = Eigen::Map<const Eigen::MatrixXf>(&need(values, "values"), n, set.params.cols());
      validate(set, "particles");
    });
  });
}

}  // extern "C"
