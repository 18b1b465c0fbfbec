// Devices, sensors and edits in Python.
#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <limits>
#include <variant>

#include "host/apps/python/bindings.hpp"

namespace simuli::python {
namespace {

/// Returns an OpenCL handle from its number or from an object of pyopencl.
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
          "name", [](const PyDevice& d) { return d.device.info().label(); }, "platform and device")
      .def("__repr__", [](const PyDevice& d) {
        return fmt::format("<simuli.Device: {}>", on_one_line(d.device.info().label()));
      });
}

namespace {

bool is_same(const Pose& a, const Pose& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

bool is_same(const Sensor& a, const Sensor& b) {
  return a.is_camera() == b.is_camera() && a.has_rays_of(b) && a.name() == b.name() &&
         a.duration_s() == b.duration_s() && is_same(a.rig_from_sensor(), b.rig_from_sensor());
}

std::string text_of(const Sensor& s) {
  return s.is_camera()
             ? fmt::format("<simuli.Sensor: camera \"{}\", {} x {} px>", s.name(), s.columns(), s.rows())
             : fmt::format(
                   "<simuli.Sensor: LiDAR \"{}\", {} beams x {} firings>", s.name(), s.rows(), s.columns());
}

/// Returns a camera's intrinsic matrix [3, 3], px.
py::object intrinsics_of(const Sensor& s) {
  const Camera& c = s.camera();
  py::list rows;
  rows.append(py::make_tuple(c.fx, 0.0, c.cx));
  rows.append(py::make_tuple(0.0, c.fy, c.cy));
  rows.append(py::make_tuple(0.0, 0.0, 1.0));
  return py::module_::import("numpy").attr("array")(rows);
}

/// State for pickle: the sensor file's text, and the properties that a file lacks.
py::tuple state_of(const Sensor& s) {
  const Pose& mount = s.rig_from_sensor();
  const Eigen::Quaterniond& q = mount.rotation;
  const Eigen::Vector3d& t = mount.translation;
  return py::make_tuple(text_of(sensor_file_of(s)),
                        s.name(),
                        s.duration_s(),
                        std::array{q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
}

Sensor sensor_of_state(const py::tuple& state) {
  if (state.size() != 4) {
    throw Error(ErrorKind::kUsage,
                "Sensor: found a state that is none, allowed one that Sensor was pickled into");
  }
  const auto m = state[3].cast<std::array<double, 7>>();
  for (const double value : m) finite(value, "Sensor");
  const Pose mount{Eigen::Quaterniond(m[0], m[1], m[2], m[3]), {m[4], m[5], m[6]}};
  const Sensor sensor = sensor_of(sensor_file_from_text(state[0].cast<std::string>(), "Sensor"));
  return sensor.named(state[1].cast<std::string>()).with_duration(state[2].cast<double>()).mounted(mount);
}

/// Converts [n][from] numbers to [n][to].
template <int from, int to, class F>
py::object map_rows(const py::object& rows, const char* what, const F& f) {
  const Numbers given = numbers_of(rows, what);
  if (given.shape.size() != 2 || given.shape[1] != from) {
    throw Error(ErrorKind::kUsage, fmt::format("{}: found another shape, allowed n x {}", what, from));
  }
  const auto out = std::make_shared<std::vector<double>>();
  for (py::ssize_t i = 0; i < given.shape[0]; ++i) {
    const Eigen::Vector<double, to> row =
        f(Eigen::Map<const Eigen::Vector<double, from>>(given.values.data() + i * from));
    out->insert(out->end(), row.begin(), row.end());
  }
  return array_on(out, out->data(), {given.shape[0], to}).attr("copy")();
}

py::object project(const Sensor& s, const py::object& points_m) {
  const Camera& camera = s.camera();
  return map_rows<3, 2>(points_m, "points_m", [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
    Eigen::Vector2d pixel;
    if (p.allFinite() && camera.project(p, pixel)) return pixel;
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  });
}

py::object unproject(const Sensor& s, const py::object& pixels) {
  const Camera& camera = s.camera();
  return map_rows<2, 3>(pixels, "pixels", [&](const Eigen::Vector2d& p) -> Eigen::Vector3d {
    const Eigen::Vector3d ray = p.allFinite() ? camera.unproject(p) : Eigen::Vector3d::Zero();
    if (!ray.isZero(0.0)) return ray;
    return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  });
}

py::dict lens_parameters(const Sensor& s) {
  const Lens& lens = s.camera().lens;
  const std::vector<std::string>& names = lens_parameter_names(lens.kind());
  py::dict out;
  for (std::size_t i = 0; i < names.size() && i < lens.parameters().size(); ++i)
    out[names[i].c_str()] = lens.parameters()[i];
  return out;
}

py::object elevations(const Sensor& s) {
  const auto* const lidar = std::get_if<Lidar>(&s.lidar());
  if (lidar == nullptr) {
    throw Error(ErrorKind::kUsage, "elevation_rad: found a LiDAR without rows, allowed one with rows");
  }
  const auto out = std::make_shared<std::vector<double>>();
  for (const LidarRow& row : lidar->rows) out->push_back(row.elevation);
  return array_on(out, out->data(), {static_cast<py::ssize_t>(out->size())});
}

// An edit as numbers: the index of ActorEdit::Change and all its values, exactly.
constexpr std::array<const char*, 5> kEdits{"remove", "move", "retime", "retrack", "turn"};
constexpr std::size_t kOfKey = 14;

std::vector<double> values_of(const ActorEdit& edit) {
  std::vector<double> values;
  if (const auto* const move = std::get_if<ActorEdit::Move>(&edit.change)) {
    values.assign(move->by_m.begin(), move->by_m.end());
  } else if (const auto* const turn = std::get_if<ActorEdit::Turn>(&edit.change)) {
    values = {turn->yaw_rad};
  } else if (const auto* const retime = std::get_if<ActorEdit::Retime>(&edit.change)) {
    values = {retime->rate, retime->delay_s};
  } else if (const auto* const retrack = std::get_if<ActorEdit::Retrack>(&edit.change)) {
    for (const KeyPose& key : retrack->track) {
      const Eigen::Quaterniond& q = key.world_from_actor.rotation;
      values.insert(values.end(), {key.time_s, q.w(), q.x(), q.y(), q.z()});
      for (const Eigen::Vector3d* const v :
           {&key.world_from_actor.translation, &key.shift_m, &key.turn_rad}) {
        values.insert(values.end(), v->begin(), v->end());
      }
    }
  }
  return values;
}

ActorEdit edit_of(const std::string& actor, std::size_t kind, const std::vector<double>& v) {
  const std::array<std::size_t, 5> counts{0, 3, 2, v.size() / kOfKey * kOfKey, 1};
  if (kind >= counts.size() || v.size() != counts.at(kind)) {
    throw Error(ErrorKind::kUsage,
                "Edit: found a state that is none, allowed one that Edit was pickled into");
  }
  switch (kind) {
    case 0:
      return {actor, ActorEdit::Remove{}};
    case 1:
      return {actor, ActorEdit::Move{{v[0], v[1], v[2]}}};
    case 2:
      return {actor, ActorEdit::Retime{v[0], v[1]}};
    case 4:
      return {actor, ActorEdit::Turn{v[0]}};
    default:
      break;
  }
  ActorEdit::Retrack retrack;
  for (std::size_t i = 0; i < v.size(); i += kOfKey) {
    retrack.track.push_back(
        {v[i],
         {Eigen::Quaterniond(v[i + 1], v[i + 2], v[i + 3], v[i + 4]), {v[i + 5], v[i + 6], v[i + 7]}},
         {v[i + 8], v[i + 9], v[i + 10]},
         {v[i + 11], v[i + 12], v[i + 13]}});
  }
  return {actor, std::move(retrack)};
}

std::string text_of(const ActorEdit& edit) {
  const auto* const retrack = std::get_if<ActorEdit::Retrack>(&edit.change);
  const std::string values = retrack != nullptr ? fmt::format("{} poses", retrack->track.size())
                                                : fmt::format("{}", fmt::join(values_of(edit), " "));
  return fmt::format("<simuli.Edit: {} \"{}\"{}{}>",
                     kEdits.at(edit.change.index()),
                     edit.actor,
                     values.empty() ? "" : ", ",
                     values);
}

}  // namespace

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
      .def_property_readonly("K", &intrinsics_of, "of a camera: 3 x 3, px, without the lens distortion")
      .def_property_readonly(
          "lens", [](const Sensor& s) { return to_string(s.camera().lens.kind()); }, "of a camera: its model")
      .def_property_readonly("lens_parameters", &lens_parameters, "of a camera: name -> value")
      .def_property_readonly(
          "shutter",
          [](const Sensor& s) { return to_string(s.camera().shutter); },
          "of a camera: \"global\", \"top_to_bottom\", ...")
      .def_property_readonly(
          "elevation_rad", &elevations, "of a LiDAR with rows: [rows], rad above its horizon")
      .def("project",
           &project,
           py::arg("points_m"),
           "Of a camera: pixels [n, 2] of points [n, 3] in its own axes; NaN where the lens has no image. It "
           "may lie "
           "outside the picture.")
      .def("unproject",
           &unproject,
           py::arg("pixels"),
           "Of a camera: unit directions [n, 3] in its own axes of pixels [n, 2]; NaN where the lens has no "
           "ray.")
      .def(py::pickle(&state_of, &sensor_of_state))
      .def(
          "__eq__", [](const Sensor& a, const Sensor& b) { return is_same(a, b); }, py::is_operator())
      .def("__hash__", &Sensor::rays_hash)
      .def("__repr__", [](const Sensor& s) { return text_of(s); })
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
        "Pixels; the centre of the first one is (0.5, 0.5). Until it is mounted() it has the mounting of a "
        "scene's "
        "first camera "
        "does.");
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
        "Beams from top to bottom. Until it is mounted() it has the mounting of a scene's first LiDAR.");
  py::class_<ActorEdit>(
      m, "Edit", "A change of what an actor does: remove, move, turn, retime, retrack.", made_objects_only())
      .def_readonly("actor", &ActorEdit::actor, "whose")
      .def(
          "__eq__",
          [](const ActorEdit& a, const ActorEdit& b) {
            return a.actor == b.actor && a.change.index() == b.change.index() && values_of(a) == values_of(b);
          },
          py::is_operator())
      .def("__hash__", [](const ActorEdit& e) { return std::hash<std::string>()(e.actor); })
      .def("__repr__", [](const ActorEdit& e) { return text_of(e); })
      .def(py::pickle(
          [](const ActorEdit& e) { return py::make_tuple(e.actor, e.change.index(), values_of(e)); },
          [](const py::tuple& state) {
            if (state.size() != 3) return edit_of("", 5, {});
            return edit_of(state[0].cast<std::string>(),
                           state[1].cast<std::size_t>(),
                           state[2].cast<std::vector<double>>());
          }));
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
