// import simuli: renders and trains from Python. Arrays are NumPy's, float32 out, whatever converts in.
#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <optional>
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/version.hpp"
#include "host/render/scene/simulator.hpp"
#include "io/log/lidar_file.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/train/training.hpp"

namespace py = pybind11;

namespace {

using namespace simuli;

using Array = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Matrix34 = Eigen::Matrix<double, 3, 4>;

/// A copy of `values` in that shape.
Array array_of(const std::vector<float>& values, std::vector<py::ssize_t> shape) {
  Array out(std::move(shape));
  std::copy(values.begin(), values.end(), out.mutable_data());
  return out;
}

Pose pose_of(const Eigen::MatrixXd& matrix) {
  if (matrix.cols() != 4 || (matrix.rows() != 3 && matrix.rows() != 4)) {
    throw Error(ErrorKind::kUsage, "pose: found another shape, allowed 4 x 4 or 3 x 4");
  }
  return Pose::from_matrix(Matrix34(matrix.topRows<3>()));
}

Eigen::MatrixXd matrix_of(const Pose& pose) { return pose.matrix(); }

class Scenery {
 public:
  Scenery(const std::string& folder, const std::string& device)
      : file_(read_scene(folder)), simulator_(Device::best(device), std::move(file_.scene)) {}

  [[nodiscard]] std::string device() const { return simulator_.device().info().label(); }
  [[nodiscard]] std::map<std::string, std::pair<int, int>> cameras() const {
    std::map<std::string, std::pair<int, int>> out;
    for (const LogCamera& c : file_.cameras) out[c.model.name] = {c.model.height, c.model.width};
    return out;
  }
  [[nodiscard]] std::map<std::string, std::pair<std::size_t, std::size_t>> lidars() const {
    std::map<std::string, std::pair<std::size_t, std::size_t>> out;
    for (const LogLidar& l : file_.lidars) {
      out[name_of(l.model)] = {row_count(l.model), ray_count(l.model) / row_count(l.model)};
    }
    return out;
  }
  [[nodiscard]] std::pair<double, double> span() const {
    if (file_.world_from_rig.poses().empty()) throw Error(ErrorKind::kInput, "scene: found no recorded path");
    return {file_.world_from_rig.start_s(), file_.world_from_rig.end_s()};
  }
  [[nodiscard]] Eigen::MatrixXd world_from_rig(double time_s) const {
    (void)span();
    return matrix_of(file_.world_from_rig.at(time_s));
  }
  [[nodiscard]] Eigen::MatrixXd rig_from_sensor(const std::string& name) const {
    if (const LogCamera* const c = file_.find_camera(name)) return matrix_of(c->rig_from_camera);
    if (const LogLidar* const l = file_.find_lidar(name)) return matrix_of(l->rig_from_lidar);
    refuse(name);
  }

  [[nodiscard]] Array render_camera(const std::string& name,
                                    const std::optional<Eigen::MatrixXd>& world_from_sensor,
                                    double time_s,
                                    double duration_s) {
    const LogCamera* const c = file_.find_camera(name);
    if (c == nullptr) refuse(name);
    const Image image =
        simulator_.render(c->model, shot(c->rig_from_camera, world_from_sensor, time_s, duration_s));
    return array_of(image.data, {image.height, image.width, 3});
  }

  [[nodiscard]] py::dict render_lidar(const std::string& name,
                                      const std::optional<Eigen::MatrixXd>& world_from_sensor,
                                      double time_s,
                                      double duration_s) {
    const LogLidar* const own = file_.find_lidar(name);
    if (own == nullptr && file_.lidars.empty() && !world_from_sensor) refuse(name);
    const LidarModel model = own != nullptr ? own->model : named(name);
    const Pose mount = own != nullptr         ? own->rig_from_lidar
                       : file_.lidars.empty() ? Pose{}
                                              : file_.lidars.front().rig_from_lidar;
    const Shot at = shot(mount, world_from_sensor, time_s, duration_s);
    const LidarFrame frame = simulator_.render(model, at);
    const auto rows = static_cast<py::ssize_t>(row_count(model));
    const auto columns = static_cast<py::ssize_t>(frame.range.size()) / rows;
    std::vector<float> points;
    for (const Eigen::Vector3d& p : world_points(model, frame, at)) {
      for (int i = 0; i < 3; ++i) points.push_back(static_cast<float>(p[i]));
    }
    py::dict out;
    out["range_m"] = array_of(frame.range, {rows, columns});
    out["intensity"] = array_of(frame.intensity, {rows, columns});
    out["drop"] = array_of(frame.drop, {rows, columns});
    out["points_m"] = array_of(points, {rows, columns, 3});
    return out;
  }

  [[nodiscard]] Eigen::MatrixXf particles(bool of_lidar) const {
    const Scene& scene = simulator_.scene();
    return of_lidar ? scene.lidar.params : scene.camera.params;
  }
  void set_particles(const Eigen::MatrixXf& params, bool of_lidar) {
    Scene scene = simulator_.scene();
    GaussianSet& set = of_lidar ? scene.lidar : scene.camera;
    if (params.cols() != set.params.cols() || (!set.actor.empty() && params.rows() != set.params.rows())) {
      throw Error(ErrorKind::kUsage, "particles: found another shape than particles() gives");
    }
    set.params = params;
    simulator_ = Simulator(simulator_.device(), std::move(scene));
  }

 private:
  [[noreturn]] void refuse(const std::string& name) const {
    throw Error(ErrorKind::kUsage, fmt::format("sensor: found \"{}\", allowed those of the scene", name));
  }
  static LidarModel named(const std::string& name) {
    if (name.ends_with(".json")) return read_lidar_file(name).model;
    return builtin_lidar(name);
  }
  [[nodiscard]] Shot shot(const Pose& mount,
                          const std::optional<Eigen::MatrixXd>& world_from_sensor,
                          double time_s,
                          double duration_s) const {
    if (world_from_sensor) return Shot::at(pose_of(*world_from_sensor), time_s, duration_s);
    (void)span();
    return Shot::along(file_.world_from_rig, mount, time_s, time_s + duration_s);
  }

  SceneFile file_;  // without its scene, which the simulator has
  Simulator simulator_;
};

/// Trains like `simuli train` with its default settings, and returns what the last frames were off by.
py::dict train(const std::string& folder,
               const std::string& output,
               int iterations,
               double image_scale,
               const std::function<void(int, double)>& progress,
               const std::string& device) {
  TrainingOptions options;
  options.train.iterations = iterations;
  options.frames.image_scale = image_scale;
  Training training(Device::best(device), read_log(folder), options);
  const TrainReport& report = training
                                  .run([&](const TrainStatus& status) {
                                    if (progress) progress(status.iteration, status.psnr_db);
                                    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
                                  })
                                  .train;
  write_scene(output, training.result());
  py::dict out;
  out["psnr_db"] = report.last.psnr_db;
  out["distance_m"] = report.last.distance_m;
  out["seconds"] = report.seconds;
  return out;
}

}  // namespace

PYBIND11_MODULE(simuli, m) {
  m.doc() = "Camera and LiDAR simulation with 3D Gaussians on any OpenCL device";
  m.attr("__version__") = simuli::version();
  py::register_exception<Error>(m, "Error", PyExc_RuntimeError);
  m.def("devices", [] {
    std::vector<std::string> names;
    for (const DeviceInfo& info : Device::list()) names.push_back(info.label());
    return names;
  });
  m.def("train",
        &train,
        py::arg("log"),
        py::arg("scene"),
        py::arg("iterations") = TrainOptions{}.iterations,
        py::arg("image_scale") = FrameSelection{}.image_scale,
        py::arg("progress") = nullptr,
        py::arg("device") = "",
        "Trains a scene from a log folder; progress(iteration, psnr_db) is called after each iteration.");
  py::class_<Scenery>(m, "Scene", "A scene folder on a device, ready to render.")
      .def(py::init<const std::string&, const std::string&>(), py::arg("folder"), py::arg("device") = "")
      .def_property_readonly("device", &Scenery::device)
      .def_property_readonly("cameras", &Scenery::cameras, "name -> (height, width), px")
      .def_property_readonly("lidars", &Scenery::lidars, "name -> (beams, firings)")
      .def_property_readonly("span", &Scenery::span, "first and last time of the recorded path, s")
      .def("world_from_rig", &Scenery::world_from_rig, py::arg("time_s"), "4 x 4, on the recorded path")
      .def("rig_from_sensor", &Scenery::rig_from_sensor, py::arg("name"), "4 x 4")
      .def("render_camera",
           &Scenery::render_camera,
           py::arg("name"),
           py::arg("world_from_sensor") = py::none(),
           py::arg("time_s") = 0.0,
           py::arg("duration_s") = 0.0,
           "float32 [height, width, 3] in [0, 1]; without a pose where the sensor was on the recorded path.")
      .def("render_lidar",
           &Scenery::render_lidar,
           py::arg("name"),
           py::arg("world_from_sensor") = py::none(),
           py::arg("time_s") = 0.0,
           py::arg("duration_s") = 0.1,
           "A LiDAR of the scene, a built-in one or a LiDAR file (.json): range_m, intensity, drop "
           "[beams, firings], points_m [beams, firings, 3] in the world; range 0: no return.")
      .def("particles",
           &Scenery::particles,
           py::arg("lidar") = false,
           "float32 [N, 11 + 3 K]: mean, log scale, rotation w x y z, opacity logit, SH coefficients.")
      .def("set_particles", &Scenery::set_particles, py::arg("params"), py::arg("lidar") = false);
}
