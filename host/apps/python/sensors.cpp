// Devices, sensors and edits in Python.
#include <cstdint>

#include "host/apps/python/bindings.hpp"

namespace simuli::python {
namespace {

/// An OpenCL handle from its number, or from an object of pyopencl's.
template <class Handle>
Handle handle_of(const py::object& from, const char* what) {
  const py::object number = py::hasattr(from, "int_ptr") ? py::object(from.attr("int_ptr")) : from;
  if (!py::isinstance<py::int_>(number) || number.cast<std::uintptr_t>() == 0) {
    throw Error(ErrorKind::kUsage,
                std::string(what) + ": found something else, allowed one of pyopencl's or its int_ptr");
  }
  return reinterpret_cast<Handle>(number.cast<std::uintptr_t>());
}

Sensor camera(const std::string& name,
              int width,
              int height,
              double fx,
              double fy,
              double cx,
              double cy,
              const std::string& lens,
              const std::vector<double>& parameters,
              const std::string& shutter,
              double duration_s) {
  const std::string where = "camera " + name;
  Camera model{name, width, height, fx, fy, cx, cy};
  model.shutter = shutter_from_string(shutter, where, "shutter");
  if (lens != "pinhole") model.lens = Lens(lens_from_string(lens, where, "lens"), parameters, where);
  return Sensor(std::move(model), {}, duration_s);
}

Sensor lidar(const std::string& name,
             const py::object& elevation_rad,
             int columns,
             double azimuth_first_rad,
             double azimuth_span_rad,
             const std::string& spin,
             double sweep_s,
             double range_min_m,
             double range_max_m,
             double beam_divergence_rad,
             const py::object& azimuth_offset_rad) {
  Lidar model;
  model.name = name;
  const std::vector<double> elevations = numbers_of(elevation_rad, "elevation_rad").values;
  std::vector<double> offsets(elevations.size(), 0.0);
  if (!azimuth_offset_rad.is_none()) offsets = numbers_of(azimuth_offset_rad, "azimuth_offset_rad").values;
  if (offsets.size() != elevations.size()) {
    throw Error(ErrorKind::kUsage, "azimuth_offset_rad: found another length, allowed elevation_rad's");
  }
  for (std::size_t i = 0; i < elevations.size(); ++i) model.rows.push_back({elevations[i], offsets[i]});
  if (spin != "clockwise" && spin != "counter_clockwise") {
    throw Error(ErrorKind::kUsage, "spin: found \"" + spin + "\", allowed clockwise or counter_clockwise");
  }
  model.columns = columns;
  model.azimuth_first = azimuth_first_rad;
  model.azimuth_span = azimuth_span_rad;
  model.spin = spin == "clockwise" ? SpinDirection::kClockwise : SpinDirection::kCounterClockwise;
  model.sweep_s = sweep_s;
  model.range_min = range_min_m;
  model.range_max = range_max_m;
  model.beam_divergence = beam_divergence_rad;
  return Sensor(LidarModel(std::move(model)));
}

ActorEdit retrack(const std::string& actor, const py::object& times_s, const py::object& world_from_actor) {
  const std::vector<double> times = numbers_of(times_s, "times_s").values;
  const std::vector<Pose> poses = poses_of(world_from_actor, "world_from_actor");
  if (times.size() != poses.size()) {
    throw Error(ErrorKind::kUsage, "times_s: found another length, allowed that of world_from_actor");
  }
  ActorEdit::Retrack track;
  for (std::size_t i = 0; i < times.size(); ++i) track.track.push_back({times[i], poses[i]});
  return {actor, std::move(track)};
}

ActorEdit move(const std::string& actor, const py::object& by_m) {
  const std::vector<double> by = numbers_of(by_m, "by_m").values;
  if (by.size() != 3) throw Error(ErrorKind::kUsage, "by_m: found another length, allowed 3");
  return {actor, ActorEdit::Move{{by[0], by[1], by[2]}}};
}

}  // namespace

PyDevice device_of(const py::object& device) {
  if (py::isinstance<PyDevice>(device)) return device.cast<PyDevice>();
  const auto request = device.is_none() ? std::string() : device.cast<std::string>();
  const GilRelease release;
  return {Device::best(request)};
}

void add_devices(py::module_& m) {
  m.def(
      "devices",
      [] {
        std::vector<std::string> names;
        for (const DeviceInfo& info : Device::list()) names.push_back(info.label());
        return names;
      },
      "The OpenCL devices of this machine, by the names that Device() takes.");
  py::class_<PyDevice>(
      m, "Device", "An OpenCL device; its calls take turns, without the GIL.", made_objects_only())
      .def(py::init([](const std::string& request) { return device_of(py::str(request)); }),
           py::arg("request") = "",
           "The best one, or the one whose name has the request in it.")
      .def_static(
          "adopt",
          [](const py::object& context, const py::object& queue) {
            return PyDevice{Device::adopt(handle_of<_cl_context*>(context, "context"),
                                          handle_of<_cl_command_queue*>(queue, "queue"))};
          },
          py::arg("context"),
          py::arg("queue"),
          "Works on a context and in-order queue of the caller's: pyopencl's, or their int_ptr.")
      .def_property_readonly(
          "name", [](const PyDevice& d) { return d.device.info().label(); }, "platform and device");
}

void add_sensors(py::module_& m) {
  py::class_<Sensor>(m, "Sensor", "A camera or a LiDAR.", made_objects_only())
      .def_property_readonly("name", &Sensor::name, "what scenes and files call it")
      .def_property_readonly("is_camera", &Sensor::is_camera, "or a LiDAR")
      .def_property_readonly(
          "shape",
          [](const Sensor& s) { return py::make_tuple(s.rows(), s.columns()); },
          "(height, width) of pictures, (beams, firings) of sweeps")
      .def_property_readonly(
          "duration_s", &Sensor::duration_s, "of a frame, from its first row or column to its last, s")
      .def_property_readonly(
          "rig_from_sensor",
          [](const Sensor& s) { return array_of(s.rig_from_sensor()); },
          "4 x 4, its mounting")
      .def("named", &Sensor::named, py::arg("name"), "The same by another name.")
      .def("resized",
           &Sensor::resized,
           py::arg("width"),
           py::arg("height"),
           "A camera of the same view with other pixels.")
      .def("with_duration",
           &Sensor::with_duration,
           py::arg("duration_s"),
           "The same whose frames take so long, s.")
      .def(
          "mounted",
          [](const Sensor& s, const py::object& mount) {
            return s.mounted(pose_of(mount, "rig_from_sensor"));
          },
          py::arg("rig_from_sensor"),
          "The same at another place on the rig: 4 x 4 or 3 x 4.");
  m.def(
      "sensor",
      [](const std::filesystem::path& name) { return named_sensor(name); },
      py::arg("name"),
      "A built-in camera or LiDAR (\"hesai_xt32@20\"), or the one of a sensor file (.json).");
  m.def("camera",
        &camera,
        py::arg("name"),
        py::arg("width"),
        py::arg("height"),
        py::arg("fx"),
        py::arg("fy"),
        py::arg("cx"),
        py::arg("cy"),
        py::arg("lens") = "pinhole",
        py::arg("parameters") = std::vector<double>{},
        py::arg("shutter") = "global",
        py::arg("duration_s") = 0.0,
        "Pixels; the centre of the first one is (0.5, 0.5).");
  m.def("lidar",
        &lidar,
        py::arg("name"),
        py::arg("elevation_rad"),
        py::arg("columns"),
        py::arg("azimuth_first_rad") = 3.141592653589793,
        py::arg("azimuth_span_rad") = 6.283185307179586,
        py::arg("spin") = "clockwise",
        py::arg("sweep_s") = kUsualSweep_s,
        py::arg("range_min_m") = 0.5,
        py::arg("range_max_m") = 200.0,
        py::arg("beam_divergence_rad") = 0.0,
        py::arg("azimuth_offset_rad") = py::none(),
        "Beams from top to bottom.");
  py::class_<ActorEdit>(
      m, "Edit", "A change of what an actor does: remove, move, turn, retime, retrack.", made_objects_only());
  m.def(
      "remove",
      [](const std::string& actor) {
        return ActorEdit{actor, ActorEdit::Remove{}};
      },
      py::arg("actor"),
      "It is gone.");
  m.def("move", &move, py::arg("actor"), py::arg("by_m"), "Forward, left, up in its own frame.");
  m.def(
      "turn",
      [](const std::string& actor, double yaw_rad) {
        return ActorEdit{actor, ActorEdit::Turn{yaw_rad}};
      },
      py::arg("actor"),
      py::arg("yaw_rad"),
      "To its left, about its own up.");
  m.def(
      "retime",
      [](const std::string& actor, double rate, double delay_s) {
        return ActorEdit{actor, ActorEdit::Retime{rate, delay_s}};
      },
      py::arg("actor"),
      py::arg("rate") = 1.0,
      py::arg("delay_s") = 0.0,
      "Its track rate times as fast, delay_s later.");
  m.def("retrack",
        &retrack,
        py::arg("actor"),
        py::arg("times_s"),
        py::arg("world_from_actor"),
        "Where it is instead: [n] times and [n, 4, 4] poses; between them by interpolation.");
}

}  // namespace simuli::python
