// Scenes in Python.
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <tuple>

#include "host/apps/python/bindings.hpp"

namespace simuli::python {
namespace {

class PyScene {
 public:
  PyScene(const std::filesystem::path& folder,
          const py::object& device,
          const std::string& quality,
          const std::vector<std::string>& settings)
      : device_(device_of(device)) {
    const DeviceLock lock(device_.mutex);
    const RenderOptions options = render_options(quality, settings);
    file_ = read_scene(folder);
    rig_ = SensorRig(file_);
    for (const std::string& note : file_.splats.notes()) {
      const std::string text = on_one_line(fmt::format("{}: {}", folder.string(), note));
      const py::gil_scoped_acquire
          python;  // taken here, because the device's lock is awaited without the GIL
      if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) < 0) throw py::error_already_set();
    }
    scene_ = std::make_shared<const Scene>(std::exchange(file_.scene, {}));
    options_ = options;
    on_device_.emplace(device_.device, scene_, options);
  }
  PyScene(const PyScene&) = delete;
  PyScene& operator=(const PyScene&) = delete;
  ~PyScene() {
    const DeviceLock lock(device_.mutex, false);
    support_.reset();
    labels_.reset();
    on_device_.reset();
  }

  [[nodiscard]] const PyDevice& device() const { return device_; }
  [[nodiscard]] SensorRig& rig() { return rig_; }
  [[nodiscard]] const std::shared_ptr<const Scene>& scene() const { return scene_; }
  [[nodiscard]] std::map<std::string, Sensor> sensors(bool cameras) const {
    return sensors_of(rig_, cameras);
  }
  /// Returns the sensor, mounted as the first of its kind on the rig unless it has a mounting.
  [[nodiscard]] Sensor in_place(const Sensor& sensor) const {
    const Pose& mount = sensor.rig_from_sensor();
    const bool is_mounted =
        !mount.translation.isZero(0.0) || mount.rotation.coeffs() != Pose{}.rotation.coeffs();
    const bool is_own = rig_.has(sensor.name()) && rig_.find(sensor.name()).has_rays_of(sensor);
    return is_mounted || is_own ? sensor : rig_.in_place(sensor);
  }
  [[nodiscard]] Eigen::Index left_out() const { return file_.splats.left_out; }
  [[nodiscard]] const FrameSpans& recorded_frames() const { return file_.recorded_frames; }
  [[nodiscard]] const Trajectory& path() const {
    if (!file_.world_from_rig.poses().empty()) return file_.world_from_rig;
    throw Error(ErrorKind::kInput, "scene: found no recorded path");
  }

  [[nodiscard]] std::shared_ptr<PyFrame> render(const py::object& sensor,
                                                const py::object& world_from_sensor,
                                                double time_s,
                                                const py::object& world_from_sensor_end,
                                                std::optional<double> duration_s,
                                                const py::object& edits,
                                                bool graded,
                                                const py::object& rays,
                                                bool actors) {
    const bool is_placed = !world_from_sensor.is_none();
    const Sensor used = sensor_of(sensor, is_placed, duration_s);
    std::optional<Pose> start, end;
    if (is_placed) start = pose_of(world_from_sensor, "world_from_sensor");
    if (!world_from_sensor_end.is_none()) end = pose_of(world_from_sensor_end, "world_from_sensor_end");
    return queue(
        used, shot_of(used, start, end, time_s, edits_of(edits)), request_of(used, graded, rays, actors));
  }

  /// Queues all frames and their transfers to the host before it returns.
  [[nodiscard]] std::vector<std::shared_ptr<PyFrame>> render_batch(const py::object& sensor,
                                                                   const py::object& time_s,
                                                                   const py::object& world_from_sensor,
                                                                   std::optional<double> duration_s,
                                                                   const py::object& edits,
                                                                   bool graded,
                                                                   const py::object& rays,
                                                                   bool actors) {
    const Numbers times = numbers_of(time_s, "time_s");
    const bool is_placed = !world_from_sensor.is_none();
    std::vector<Pose> poses;
    if (is_placed) poses = poses_of(world_from_sensor, "world_from_sensor");
    if (times.shape.size() != 1 || (is_placed && poses.size() != times.values.size())) {
      throw Error(ErrorKind::kUsage, "time_s: found another shape, allowed one time for each pose");
    }
    const Sensor used = sensor_of(sensor, is_placed, duration_s);
    const FrameRequest request = request_of(used, graded, rays, actors);
    const std::vector<ActorEdit> given = edits_of(edits);
    std::vector<std::shared_ptr<PyFrame>> frames;
    for (std::size_t i = 0; i < times.values.size(); ++i) {
      const auto start = is_placed ? std::optional(poses[i]) : std::nullopt;
      frames.push_back(queue(used, shot_of(used, start, {}, times.values[i], given), request));
      const DeviceLock lock(device_.mutex);
      frames.back()->frame().fetch();
    }
    return frames;
  }

  void change(const std::function<void(Scene&)>& f) {
    const DeviceLock lock(device_.mutex);
    Scene changed = *scene_;
    f(changed);
    scene_ = std::make_shared<const Scene>(std::move(changed));
    on_device_->set_scene(scene_);
    labels_.reset();
  }
  [[nodiscard]] bool mirror(const std::string& actor, const std::string& recorded) {
    if (file_.support == nullptr) {
      throw Error(
          ErrorKind::kUsage,
          "mirror_actor: found a scene without a record of the seen sides of actors, allowed one with it: "
          "train it again");
    }
    bool done = false;
    change([&](Scene& s) {
      done =
          mirror_actor(s, *file_.support, actor, recorded.empty() ? original_of(copies_, actor) : recorded);
    });
    return done;
  }
  void duplicate(const std::string& actor, const std::string& as) {
    change([&](Scene& s) { duplicate_actor(s, actor, as); });
    add_copy(copies_, actor, as);
  }
  void edit(const ActorEdit& edit) {
    change([&](Scene& s) { edit_actor(s, edit); });
    if (std::holds_alternative<ActorEdit::Remove>(edit.change)) copies_.erase(edit.actor);
  }
  void save(const std::filesystem::path& folder) const {
    SceneFile file = file_;
    file.scene = *scene_;
    const GilRelease release;
    write_scene(folder, file);
  }

  [[nodiscard]] py::object particles(bool of_lidar) const {
    const Eigen::MatrixXf& params = of_lidar ? scene_->lidar.params : scene_->camera.params;
    return on_matrix(scene_, params).attr("copy")();
  }
  void set_particles(const py::object& params, bool of_lidar) {
    const Numbers given = numbers_of(params, "particles");
    change([&](Scene& s) {
      GaussianSet& set = of_lidar ? s.lidar : s.camera;
      const bool as_many = given.shape.size() == 2 && given.shape[0] == set.params.rows();
      if (given.shape.size() != 2 || given.shape[0] == 0 || given.shape[1] != set.params.cols() ||
          (!as_many && has_particles_of_actors(s, set))) {
        throw Error(ErrorKind::kUsage, "particles: found another shape than particles() gives");
      }
      if (!as_many) set.actor.clear();  // disoccluded Gaussians are removed
      using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      const Eigen::Map<const Rows> values(given.values.data(), given.shape[0], given.shape[1]);
      set.params = values.cast<float>();
      validate(set, "particles");
    });
  }
  [[nodiscard]] py::object gradients(const PyFrame& frame,
                                     const py::object& feature,
                                     const py::object& transmittance,
                                     const py::object& distance_sum_m) {
    const std::size_t rays = frame.frame().sensor().ray_count();
    RayGradients given;
    for (std::size_t c = 0; c < 3 && !feature.is_none(); ++c) {
      const std::vector<double> values = per_ray(feature, "feature", 3 * rays);
      for (std::size_t i = 0; i < rays; ++i)
        given.feature[c].push_back(static_cast<float>(values[3 * i + c]));
    }
    for (const auto& [from, to, name] : {std::tuple(&transmittance, &given.transmittance, "transmittance"),
                                         std::tuple(&distance_sum_m, &given.distance, "distance_sum_m")}) {
      if (from->is_none()) continue;
      const std::vector<double> values = per_ray(*from, name, rays);
      to->assign(values.begin(), values.end());
    }
    const auto found = [&] {
      const DeviceLock lock(device_.mutex);
      return std::make_shared<const Eigen::MatrixXf>(on_device_->gradients(frame.frame(), given));
    }();
    return on_matrix(found, *found);
  }

  [[nodiscard]] py::list labels(const PyFrame& frame) {
    const std::vector<ActorLabel> found = [&] {
      const DeviceLock lock(device_.mutex);
      if (!labels_) labels_.emplace(device_.device, scene_, options_);
      return labels_->of(frame.frame());
    }();
    return labels_as_dicts(found, *scene_, frame.frame().sensor().is_camera());
  }

  [[nodiscard]] py::tuple flow(const PyFrame& frame, const PyFrame& to) {
    const auto found = [&] {
      const DeviceLock lock(device_.mutex);
      return std::make_shared<const Flow>(flow_of(frame.frame(), *scene_, to.frame().shot()));
    }();
    const auto array = [&found](const Image& image) {
      return array_on(found, image.data.data(), {image.height, image.width, 3});
    };
    return py::make_tuple(array(found->pixels), array(found->points));
  }

  [[nodiscard]] py::object support(const PyFrame& frame, const ActorCopies& copies) {
    const auto found = [&] {
      const DeviceLock lock(device_.mutex);
      if (!support_) support_.emplace(device_.device, file_.support);
      ActorCopies all = copies;
      all.insert(copies_.begin(), copies_.end());
      return std::make_shared<const std::vector<float>>(support_->of(frame.frame(), *scene_, all));
    }();
    const Sensor& sensor = frame.frame().sensor();
    return array_on(found,
                    found->data(),
                    {static_cast<py::ssize_t>(sensor.rows()), static_cast<py::ssize_t>(sensor.columns())});
  }

 private:
  /// Returns a column-major matrix as a NumPy array without a copy.
  static py::object on_matrix(std::shared_ptr<const void> owner, const Eigen::MatrixXf& matrix) {
    constexpr py::ssize_t kReal = sizeof(float);
    return array_on(
        std::move(owner), matrix.data(), {matrix.rows(), matrix.cols()}, {kReal, kReal * matrix.rows()});
  }
  static std::vector<double> per_ray(const py::object& from, const std::string& what, std::size_t count) {
    Numbers given = numbers_of(from, what);
    if (given.values.size() == count) return std::move(given.values);
    throw Error(ErrorKind::kUsage,
                what + ": found " + std::to_string(given.values.size()) + " values, allowed " +
                    std::to_string(count));
  }

  [[nodiscard]] Sensor sensor_of(const py::object& sensor,
                                 bool is_placed,
                                 std::optional<double> duration_s) const {
    const auto found = [&] {
      if (py::isinstance<Sensor>(sensor))
        return is_placed ? sensor.cast<Sensor>() : in_place(sensor.cast<Sensor>());
      if (!py::isinstance<py::str>(sensor) && !py::hasattr(sensor, "__fspath__")) {
        throw Error(ErrorKind::kUsage, "sensor: found something else, allowed a Sensor, a name or a path");
      }
      std::string name;
      try {
        name = sensor.cast<std::filesystem::path>();
      } catch (const py::cast_error&) {
        throw Error(ErrorKind::kUsage, "sensor: found a name with a zero in it, allowed one without");
      }
      return is_placed ? rig_.find(name, Pose{}) : rig_.find(name);
    }();
    if (!duration_s) return found;
    if (!(*duration_s >= 0.0) || !std::isfinite(*duration_s)) {
      throw Error(ErrorKind::kUsage,
                  "duration_s: found " + std::to_string(*duration_s) + ", allowed 0 or more and finite");
    }
    return found.with_duration(*duration_s);
  }
  [[nodiscard]] Shot shot_of(const Sensor& sensor,
                             const std::optional<Pose>& start,
                             const std::optional<Pose>& end,
                             double time_s,
                             const std::vector<ActorEdit>& edits) const {
    finite(time_s, "time_s");
    if (end && !start) {
      throw Error(ErrorKind::kUsage,
                  "world_from_sensor_end: found without world_from_sensor, allowed with it");
    }
    Shot shot = start ? Shot::at(*start, time_s, sensor.duration_s()) : Shot::along(path(), sensor, time_s);
    if (end) shot.world_from_sensor_end = *end;
    shot.edits = edits;
    return shot;
  }
  /// rays: None, or flags [rows, columns].
  [[nodiscard]] static FrameRequest request_of(const Sensor& sensor,
                                               bool graded,
                                               const py::object& rays,
                                               bool actors) {
    FrameRequest out{.graded = graded, .camera_median = true, .actors = actors};
    if (rays.is_none()) return out;
    const Numbers flags = numbers_of(rays, "rays");
    const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(sensor.rows()),
                                         static_cast<py::ssize_t>(sensor.columns())};
    if (flags.shape != shape) {
      throw Error(ErrorKind::kUsage,
                  "rays: found another shape, allowed the sensor's, " + std::to_string(sensor.rows()) +
                      " x " + std::to_string(sensor.columns()));
    }
    for (const double flag : flags.values) out.rays.push_back(flag != 0.0);
    return out;
  }
  [[nodiscard]] std::shared_ptr<PyFrame> queue(const Sensor& sensor,
                                               const Shot& shot,
                                               const FrameRequest& request) {
    const DeviceLock lock(device_.mutex);
    return std::make_shared<PyFrame>(on_device_->render(sensor, shot, request), device_.mutex);
  }

  PyDevice device_;
  SceneFile file_;  // without its scene
  SensorRig rig_;
  std::shared_ptr<const Scene> scene_;
  ActorCopies copies_;
  std::optional<SceneOnDevice> on_device_;
  RenderOptions options_;
  std::optional<SupportOnDevice> support_;  // created on first use
  std::optional<LabelsOnDevice> labels_;    // for scene_; created on first use
};

void add_rendering(py::class_<PyScene>& scene) {
  scene
      .def("render",
           &PyScene::render,
           py::arg("sensor"),
           py::arg("world_from_sensor") = py::none(),
           py::arg("time_s") = 0.0,
           py::arg("world_from_sensor_end") = py::none(),
           py::arg("duration_s") = py::none(),
           py::arg("edits") = py::list(),
           py::arg("graded") = true,
           py::arg("rays") = py::none(),
           py::arg("actors") = false,
           "Queues a frame of a Sensor, or of a name: a sensor of the scene, a built-in one, a sensor file. "
           "Without a pose the sensor follows the recorded trajectory. graded: pictures through the scene's "
           "colour "
           "grids; rays: [rows, columns], rays with nonzero flags are rendered, others show the background; "
           "actors: also frame.actors.")
      .def("render_batch",
           &PyScene::render_batch,
           py::arg("sensor"),
           py::arg("time_s"),
           py::arg("world_from_sensor") = py::none(),
           py::arg("duration_s") = py::none(),
           py::arg("edits") = py::list(),
           py::arg("graded") = true,
           py::arg("rays") = py::none(),
           py::arg("actors") = false,
           "Queues a frame for each time (and pose, [n, 4, 4]) before the first is finished.")
      .def("particles",
           &PyScene::particles,
           py::arg("lidar") = false,
           "float32 [N, 11 + 3 K]: mean, log scale, rotation w x y z, opacity logit, SH coefficients.")
      .def("set_particles",
           &PyScene::set_particles,
           py::arg("params"),
           py::arg("lidar") = false,
           "Replaces particles(); a different number is allowed only if no actor has particles.")
      .def("gradients",
           &PyScene::gradients,
           py::arg("frame"),
           py::arg("feature") = py::none(),
           py::arg("transmittance") = py::none(),
           py::arg("distance_sum_m") = py::none(),
           "dL/d(particles) [N, 11 + 3 K] from dL/d(a frame's arrays); 0 for particles that no ray sees.")
      .def(
          "support",
          &PyScene::support,
          py::arg("frame"),
          py::arg("copies") = ActorCopies{},
          "float32 [rows, columns] in [0, 1]: how well the training frames support each ray of a frame of "
          "this "
          "scene; 0: not at all. Copies made by duplicate_actor() count as their originals. copies: names of "
          "further copies -> names of their originals.")
      .def("labels",
           &PyScene::labels,
           py::arg("frame"),
           "Of a frame of this scene rendered with actors=True, a dict for each actor that is there: its box "
           "as "
           "the sensor saw it, pixels or returns of its body, occlusion, and 2D boxes (docs/RENDERS.md).")
      .def(
          "flow",
          &PyScene::flow,
          py::arg("frame"),
          py::arg("to"),
          "float32 [rows, columns, 3] twice, of a camera's frame rendered with actors=True to another of it: "
          "px right, px down and whether there is such a place; m in the camera's axes.");
}

}  // namespace

void add_scenes(py::module_& m) {
  py::class_<PyScene> scene(m, "Scene", "A scene folder on a device, ready to render.", made_objects_only());
  scene
      .def(py::init<const std::filesystem::path&,
                    const py::object&,
                    const std::string&,
                    const std::vector<std::string>&>(),
           py::arg("folder"),
           py::arg("device") = py::none(),
           py::arg("quality") = "",
           py::arg("settings") = std::vector<std::string>{},
           "quality: draft, balanced, exact or reference; settings: \"render.KEY=VALUE\".")
      .def_property_readonly(
          "device", [](const PyScene& s) { return s.device().device.info().label(); }, "its name")
      .def_property_readonly(
          "cameras", [](const PyScene& s) { return s.sensors(true); }, "name -> Sensor")
      .def_property_readonly(
          "lidars", [](const PyScene& s) { return s.sensors(false); }, "name -> Sensor")
      .def(
          "add_sensor",
          [](PyScene& s, const Sensor& sensor) { s.rig().add(s.in_place(sensor)); },
          py::arg("sensor"),
          "Adds a sensor to the scene, to be rendered by its name.")
      .def_property_readonly(
          "span",
          [](const PyScene& s) { return std::pair(s.path().start_s(), s.path().end_s()); },
          "first and last time of the recorded path, s")
      .def_property_readonly(
          "recorded_frames",
          [](const PyScene& s) { return spans_of(s.recorded_frames()); },
          "start and end of each frame that was recorded, s, by sensor")
      .def_property_readonly(
          "left_out",
          &PyScene::left_out,
          "of a file of splats: particles with NaN, Inf or a zero quaternion, with a warning")
      .def(
          "world_from_rig",
          [](const PyScene& s, double time_s) { return array_of(s.path().at(finite(time_s, "time_s"))); },
          py::arg("time_s"),
          "4 x 4, on the recorded path")
      .def_property_readonly(
          "origin_m",
          [](const PyScene& s) {
            const Eigen::Vector3d& origin = s.scene()->origin;
            return std::tuple(origin.x(), origin.y(), origin.z());
          },
          "where in the world the means of particles() count from")
      .def_property_readonly(
          "actors",
          [](const PyScene& s) { return actors_as_dicts(s.scene()->actors); },
          "name, kind, size_m, times_s, world_from_actor of each")
      .def("edit", &PyScene::edit, py::arg("edit"), "remove(), move(), retime(), retrack(): for all frames.")
      .def("duplicate_actor",
           &PyScene::duplicate,
           py::arg("actor"),
           py::arg("new_name"),
           "Adds a copy of an actor with the same track, until it is edited.")
      .def(
          "add_actor",
          [](PyScene& s, const PyScene& other, const std::string& actor, const std::string& as) {
            const std::shared_ptr<const Scene> from = other.scene();
            s.change([&](Scene& scene_) { add_actor(scene_, *from, actor, as); });
          },
          py::arg("other"),
          py::arg("actor"),
          py::arg("new_name"),
          "An actor of another scene, with its particles and its track.")
      .def(
          "add_object",
          [](PyScene& s, const PyScene& object, const std::string& as, const py::object& world_from_base) {
            const Scene actor = as_actor(*object.scene(), as, pose_of(world_from_base, "world_from_base"));
            s.change([&](Scene& scene_) { add_actor(scene_, actor, as, as); });
          },
          py::arg("object"),
          py::arg("new_name"),
          py::arg("world_from_base"),
          "Adds the static content of another scene, or a file of splats, as an actor. world_from_base: 4 x "
          "4, "
          "the permanent pose of the centre of its base.")
      .def(
          "resize_actor",
          [](PyScene& s, const std::string& actor, double factor) {
            s.change([&](Scene& scene_) { resize_actor(scene_, actor, factor); });
          },
          py::arg("actor"),
          py::arg("factor"),
          "Scales an actor by a factor; its ground position stays.")
      .def("mirror_actor",
           &PyScene::mirror,
           py::arg("actor"),
           py::arg("recorded") = "",
           "Mirrors an actor of which one side was recorded to its other side. Returns False and does "
           "nothing if "
           "both sides were seen, or none. recorded: the recorded actor; default: the original of a "
           "duplicated "
           "actor.")
      .def("__repr__",
           [](const PyScene& s) {
             return fmt::format("<simuli.Scene: \"{}\", {} cameras, {} LiDARs, {} actors, on {}>",
                                on_one_line(s.scene()->name),
                                s.sensors(true).size(),
                                s.sensors(false).size(),
                                s.scene()->actors.size(),
                                s.device().device.info().label());
           })
      .def("save", &PyScene::save, py::arg("folder"), "Writes the scene as it is now.");
  add_rendering(scene);
}

}  // namespace simuli::python
