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
#include "host/render/scene/scene_on_device.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/scene/sensor_rig.hpp"
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
  Scenery(const std::string& folder, const std::string& device) : Scenery(read_scene(folder), device) {}

  [[nodiscard]] std::string device() const { return scene_.device().info().label(); }
  [[nodiscard]] std::map<std::string, std::pair<std::size_t, std::size_t>> sensors(bool cameras) const {
    std::map<std::string, std::pair<std::size_t, std::size_t>> out;
    for (const Sensor& s : rig_.sensors()) {
      if (s.is_camera() == cameras) out[s.name()] = {s.rows(), s.columns()};
    }
    return out;
  }
  [[nodiscard]] std::pair<double, double> span() const {
    if (world_from_rig_.poses().empty()) throw Error(ErrorKind::kInput, "scene: found no recorded path");
    return {world_from_rig_.start_s(), world_from_rig_.end_s()};
  }
  [[nodiscard]] Eigen::MatrixXd world_from_rig(double time_s) const {
    (void)span();
    return matrix_of(world_from_rig_.at(time_s));
  }
  [[nodiscard]] Eigen::MatrixXd rig_from_sensor(const std::string& name) const {
    return matrix_of(rig_.find(name).rig_from_sensor());
  }

  [[nodiscard]] Array render_camera(const std::string& name,
                                    const std::optional<Eigen::MatrixXd>& world_from_sensor,
                                    double time_s,
                                    std::optional<double> duration_s) {
    const Image image = frame(name, world_from_sensor, time_s, duration_s).image();
    return array_of(image.data, {image.height, image.width, 3});
  }

  [[nodiscard]] py::dict render_lidar(const std::string& name,
                                      const std::optional<Eigen::MatrixXd>& world_from_sensor,
                                      double time_s,
                                      std::optional<double> duration_s) {
    const Frame rendered = frame(name, world_from_sensor, time_s, duration_s);
    const LidarFrame sweep = rendered.lidar();
    const auto rows = static_cast<py::ssize_t>(rendered.sensor().rows());
    const auto columns = static_cast<py::ssize_t>(rendered.sensor().columns());
    py::array_t<double> points({rows, columns, py::ssize_t{3}});
    double* to = points.mutable_data();
    for (const Eigen::Vector3d& p : rendered.points()) to = std::copy(p.begin(), p.end(), to);
    py::dict out;
    out["range_m"] = array_of(sweep.range, {rows, columns});
    out["intensity"] = array_of(sweep.intensity, {rows, columns});
    out["drop"] = array_of(sweep.drop, {rows, columns});
    out["points_m"] = points;
    return out;
  }

  [[nodiscard]] Eigen::MatrixXf particles(bool of_lidar) const {
    const Scene& scene = scene_.scene();
    return of_lidar ? scene.lidar.params : scene.camera.params;
  }
  void set_particles(const Eigen::MatrixXf& params, bool of_lidar) {
    Scene scene = scene_.scene();
    GaussianSet& set = of_lidar ? scene.lidar : scene.camera;
    if (params.cols() != set.params.cols() || (!set.actor.empty() && params.rows() != set.params.rows())) {
      throw Error(ErrorKind::kUsage, "particles: found another shape than particles() gives");
    }
    set.params = params;
    scene_.set_scene(std::move(scene));
  }

 private:
  Scenery(SceneFile file, const std::string& device)
      : rig_(file),
        world_from_rig_(std::move(file.world_from_rig)),
        scene_(Device::best(device), std::move(file.scene)) {}

  [[nodiscard]] Frame frame(const std::string& name,
                            const std::optional<Eigen::MatrixXd>& world_from_sensor,
                            double time_s,
                            std::optional<double> duration_s) {
    Sensor sensor = world_from_sensor ? rig_.find(name, Pose{}) : rig_.find(name);
    if (duration_s) sensor = sensor.with_duration(*duration_s);
    if (world_from_sensor) {
      return scene_.render(sensor, Shot::at(pose_of(*world_from_sensor), time_s, sensor.duration_s()));
    }
    (void)span();
    return scene_.render(sensor, Shot::along(world_from_rig_, sensor, time_s));
  }

  SensorRig rig_;
  Trajectory world_from_rig_;
  SceneOnDevice scene_;
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
      .def_property_readonly(
          "cameras", [](const Scenery& s) { return s.sensors(true); }, "name -> (height, width), px")
      .def_property_readonly(
          "lidars", [](const Scenery& s) { return s.sensors(false); }, "name -> (beams, firings)")
      .def_property_readonly("span", &Scenery::span, "first and last time of the recorded path, s")
      .def("world_from_rig", &Scenery::world_from_rig, py::arg("time_s"), "4 x 4, on the recorded path")
      .def("rig_from_sensor", &Scenery::rig_from_sensor, py::arg("name"), "4 x 4")
      .def("render_camera",
           &Scenery::render_camera,
           py::arg("name"),
           py::arg("world_from_sensor") = py::none(),
           py::arg("time_s") = 0.0,
           py::arg("duration_s") = py::none(),
           "float32 [height, width, 3] in [0, 1]; without a pose where the sensor was on the recorded path.")
      .def("render_lidar",
           &Scenery::render_lidar,
           py::arg("name"),
           py::arg("world_from_sensor") = py::none(),
           py::arg("time_s") = 0.0,
           py::arg("duration_s") = py::none(),
           "A LiDAR of the scene, a built-in one or a LiDAR file (.json): range_m, intensity, drop "
           "[beams, firings], points_m float64 [beams, firings, 3] in the world; range 0: no return.")
      .def("particles",
           &Scenery::particles,
           py::arg("lidar") = false,
           "float32 [N, 11 + 3 K]: mean, log scale, rotation w x y z, opacity logit, SH coefficients.")
      .def("set_particles", &Scenery::set_particles, py::arg("params"), py::arg("lidar") = false);
}
