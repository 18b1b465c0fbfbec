// Recorded drives in Python.
#include <fmt/format.h>
#include <utility>

#include "host/apps/python/bindings.hpp"

namespace simuli::python {
namespace {

template <class F>
auto without_gil(const F& f) {
  const GilRelease release;
  return std::make_shared<const decltype(f())>(f());
}

class PyLog {
 public:
  explicit PyLog(const std::filesystem::path& folder) : log_(read(folder)), rig_(log_) {}

  [[nodiscard]] const Log& log() const { return log_; }
  [[nodiscard]] const SensorRig& rig() const { return rig_; }

  [[nodiscard]] py::object image(const std::string& camera, py::ssize_t index) const {
    const Camera& model = log_.camera(camera).model;
    const ImageFrame& frame = frame_of(log_.images, &ImageFrame::camera, camera, index);
    const auto image = without_gil(
        [&] { return read_image(log_.folder / frame.file, model.width, model.height, "camera " + camera); });
    return array_on(image, image->data.data(), {image->height, image->width, image->channels});
  }

  [[nodiscard]] py::dict sweep(const std::string& lidar, py::ssize_t index) const {
    const LogLidar& of = log_.lidar(lidar);
    const SweepFrame& frame = frame_of(log_.sweeps, &SweepFrame::lidar, lidar, index);
    struct Read {
      LidarFrame frame;
      std::vector<float> time_s;
      std::vector<Eigen::Vector3d> points;
    };
    const auto read = without_gil([&] {
      Sweep sweep = read_sweep(log_.folder / frame.file, of.model);
      Read out{{std::move(sweep.rays), std::move(sweep.range), std::move(sweep.intensity), {}}, {}, {}};
      const Shot shot =
          Shot::along(log_.world_from_rig, of.rig_from_lidar, frame.time_start_s, frame.time_end_s);
      out.points = points_of(of.model, out.frame, shot, PointFrame::kWorld);
      for (std::size_t i = 0; i < out.frame.range.size(); ++i) {
        out.time_s.push_back(static_cast<float>(static_cast<double>(out.frame.rays.time_fraction[i]) *
                                                (frame.time_end_s - frame.time_start_s)));
        float& range = out.frame.range[i];
        if (range > 0.0F) range = stated_range(of.model, out.frame.rays, i, range);
      }
      return out;
    });
    const std::vector<py::ssize_t> shape{read->frame.rays.rows, read->frame.rays.columns};
    py::dict out;
    out["range_m"] = array_on(read, read->frame.range.data(), shape);
    out["intensity"] = array_on(read, read->frame.intensity.data(), shape);
    out["time_s"] = array_on(read, read->time_s.data(), shape);
    out["points_m"] = array_on(read, read->points.data()->data(), {shape[0], shape[1], 3});
    return out;
  }

 private:
  static Log read(const std::filesystem::path& folder) {
    const GilRelease release;
    const Interruption interruption(signals());
    return read_log(folder);
  }
  /// Returns a sensor's frame by index.
  template <class Frame>
  static const Frame& frame_of(const std::vector<Frame>& frames,
                               std::string Frame::*sensor,
                               const std::string& name,
                               py::ssize_t index) {
    py::ssize_t count = 0;
    for (const Frame& frame : frames) {
      if (frame.*sensor == name && count++ == index) return frame;
    }
    throw Error(ErrorKind::kUsage,
                fmt::format("index: found {}, allowed 0 to {} of {}", index, count - 1, name));
  }

  Log log_;
  SensorRig rig_;
};

}  // namespace

void add_logs(py::module_& m) {
  py::class_<PyLog>(m, "Log", "A recorded drive: a log folder.", made_objects_only())
      .def(py::init<const std::filesystem::path&>(), py::arg("folder"))
      .def_property_readonly(
          "name", [](const PyLog& l) { return l.log().name; }, "of the drive")
      .def_property_readonly(
          "cameras", [](const PyLog& l) { return sensors_of(l.rig(), true); }, "name -> Sensor")
      .def_property_readonly(
          "lidars", [](const PyLog& l) { return sensors_of(l.rig(), false); }, "name -> Sensor")
      .def_property_readonly(
          "span",
          [](const PyLog& l) {
            return std::pair(l.log().world_from_rig.start_s(), l.log().world_from_rig.end_s());
          },
          "first and last time of the recorded path, s")
      .def_property_readonly(
          "start_ns", [](const PyLog& l) { return l.log().start_ns; }, "what all seconds count from")
      .def_property_readonly(
          "recorded_frames",
          [](const PyLog& l) { return spans_of(frame_spans(l.log())); },
          "start and end of each frame, s, by sensor")
      .def_property_readonly(
          "actors",
          [](const PyLog& l) { return actors_as_dicts(l.log().actors); },
          "name, kind, size_m, times_s, world_from_actor of each")
      .def(
          "world_from_rig",
          [](const PyLog& l, double time_s) {
            return array_of(l.log().world_from_rig.at(finite(time_s, "time_s")));
          },
          py::arg("time_s"),
          "4 x 4, on the recorded path")
      .def("image",
           &PyLog::image,
           py::arg("camera"),
           py::arg("index"),
           "float32 [height, width, 3] in [0, 1]: the picture of recorded_frames[camera][index], as "
           "Frame.image.")
      .def("sweep",
           &PyLog::sweep,
           py::arg("lidar"),
           py::arg("index"),
           "range_m, intensity, time_s [rows, columns] and points_m [rows, columns, 3] of "
           "recorded_frames[lidar][index], as Frame's.")
      .def("__repr__", [](const PyLog& l) {
        return fmt::format("<simuli.Log: \"{}\", {} pictures, {} sweeps, {} actors>",
                           on_one_line(l.log().name),
                           l.log().images.size(),
                           l.log().sweeps.size(),
                           l.log().actors.size());
      });
}

}  // namespace simuli::python
