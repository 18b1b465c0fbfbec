// Frames in Python.
#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <iterator>
#include <simuli/opencl.h>

#include "host/apps/python/bindings.hpp"

namespace simuli::python {
namespace {

std::vector<py::ssize_t> shape_of(const Sensor& sensor) {
  return {static_cast<py::ssize_t>(sensor.rows()), static_cast<py::ssize_t>(sensor.columns())};
}

/// Attributes of frames with their documentation.
constexpr std::pair<const char*, const char*> kArrays[] = {
    {"image", "of cameras: [height, width, 3] in [0, 1]"},
    {"feature", "[rows, columns, 3] as blended: colour, or intensity, hit logit, drop logit"},
    {"transmittance", "light that comes through all"},
    {"opacity", "1 - transmittance"},
    {"distance_m", "expected distance along each ray; 0: no surface"},
    {"median_m", "where half of the light is gone; 0: nowhere"},
    {"distance_sum_m", "sum of w tau: distance_m times opacity, what gradients are taken of"},
    {"depth_m", "of cameras: the part of median_m along the optical axis"},
    {"mean_depth_m", "of cameras: the part of distance_m along the optical axis"},
    {"normals",
     "of cameras: [height, width, 3] of the surface at median_m, in the camera's axes and towards it; "
     "zeros: "
     "none"},
    {"range_m", "of LiDARs, from the ray's own origin; 0: no return"},
    {"intensity", "of LiDARs, [0, 1]"},
    {"drop", "of LiDARs: probability that the ray does not return"},
    {"time_s", "of LiDARs: when the ray is fired, since the frame's start"},
};

py::object values(PyFrame& frame, const std::string& name) {
  return py::module_::import("numpy").attr("asarray")(frame.tensor(name));
}

/// Returns the main array of a frame.
py::object main_tensor(PyFrame& frame) {
  return frame.tensor(frame.frame().sensor().is_camera() ? "image" : "range_m");
}

std::string text_of(const PyFrame& f) {
  const Sensor& s = f.frame().sensor();
  return fmt::format("<simuli.Frame: {} \"{}\", {} x {}, at {:.3f} s>",
                     s.is_camera() ? "camera" : "LiDAR",
                     s.name(),
                     s.is_camera() ? s.columns() : s.rows(),
                     s.is_camera() ? s.rows() : s.columns(),
                     f.frame().shot().time_start_s);
}

std::uintptr_t number_of(const void* handle) { return reinterpret_cast<std::uintptr_t>(handle); }

}  // namespace

PyFrame::~PyFrame() {
  const DeviceLock lock(mutex_, false);
  frame_.reset();
}

void PyFrame::wait() const {
  if (Device::is_forked()) return;  // in a forked child, host data is readable, the rest is refused
  frame().fetch();
  frame().wait();
}

std::vector<float> PyFrame::computed(const std::string& name) const {
  if (name == "image") return frame().image().data;
  if (name == "range_m") return frame().lidar().range;
  if (name == "intensity") return frame().lidar().intensity;
  if (name == "drop") return frame().lidar().drop;
  if (name == "time_s") {
    std::vector<float> times = frame().sensor().rays().time_fraction;
    const double duration_s = frame().shot().time_end_s - frame().shot().time_start_s;
    for (float& time : times) time = static_cast<float>(static_cast<double>(time) * duration_s);
    return times;
  }
  if (name == "depth_m") return image_of(frame(), CameraOutput::kDepth).data;
  if (name == "mean_depth_m") return image_of(frame(), CameraOutput::kMeanDepth).data;
  if (name == "normals") return image_of(frame(), CameraOutput::kNormals).data;
  if (name == "actors") {
    const std::vector<std::uint32_t> ids = frame().actors();
    return {ids.begin(), ids.end()};
  }
  const RayResults& r = frame().results();
  std::vector<float> out;
  out.reserve(r.rays);
  for (std::size_t i = 0; i < r.rays; ++i) {
    if (name == "feature") {
      for (const std::vector<float>& channel : r.feature) out.push_back(channel[i]);
    } else {
      out.push_back(name == "opacity" ? 1.0F - r.transmittance[i] : r.expected_distance(i));
    }
  }
  return out;
}

/// Returns the library's arrays in place; computes the others once.
py::object PyFrame::tensor(const std::string& name) {
  std::vector<py::ssize_t> shape = shape_of(frame().sensor());
  const std::vector<float>* values = nullptr;
  {
    const DeviceLock lock(mutex_);
    wait();
    if (name == "transmittance") {
      values = &frame().results().transmittance;
    } else if (name == "distance_sum_m") {
      values = &frame().results().distance;
    } else if (name == "median_m") {
      values = &frame().results().median;
      if (values->empty()) {
        throw Error(ErrorKind::kUsage, "median_m: found a frame rendered with render.median_distance=false");
      }
    } else {
      auto& known = computed_[name];
      if (!known) known = std::make_shared<const std::vector<float>>(computed(name));
      values = known.get();
    }
  }
  if (name == "image" || name == "feature" || name == "normals") shape.push_back(3);
  return tensor_on(shared_from_this(), values->data(), std::move(shape));
}

py::object PyFrame::points() {
  std::vector<py::ssize_t> shape = shape_of(frame().sensor());
  shape.push_back(3);
  {
    const DeviceLock lock(mutex_);
    wait();
    if (!points_) points_ = std::make_shared<const std::vector<Eigen::Vector3d>>(frame().points());
  }
  return array_on(shared_from_this(), points_->data()->data(), std::move(shape));
}

py::dict PyFrame::cloud(const std::string& in) const {
  const auto cloud = [&] {
    const DeviceLock lock(mutex_);
    wait();
    return std::make_shared<const PointCloud>(
        point_cloud(frame(), {.frame = point_frame(in), .coordinates = ColumnType::kDouble}));
  }();
  const auto all = array_on(cloud, cloud->values.data(), {cloud->values.rows(), cloud->values.cols()});
  const auto columns = [&all](const py::object& which) {
    return all.attr("__getitem__")(py::make_tuple(py::ellipsis(), which));
  };
  py::dict out;
  out["xyz"] = columns(py::slice(0, 3, 1));
  for (std::size_t c = 3; c < cloud->columns.size(); ++c) {
    const char* type = cloud->type(c) == ColumnType::kUint16 ? "uint16" : "float32";
    out[cloud->columns[c].c_str()] = columns(py::int_(c)).attr("astype")(type);
  }
  return out;
}

py::dict PyFrame::memory() const {
  const simuli_frame_memory m = [&] {
    const DeviceLock lock(mutex_);
    return opencl::memory(frame());
  }();
  py::dict out;
  out["outputs"] = number_of(m.outputs);
  out["picture"] = m.picture == nullptr ? py::object(py::none()) : py::int_(number_of(m.picture));
  out["ray_of_slot"] = number_of(m.ray_of_slot);
  out["slot_of_ray"] = number_of(m.slot_of_ray);
  out["ready"] = number_of(m.ready);
  out["slots"] = m.slots;
  out["rays"] = m.rays;
  out["dtype"] = m.is_double != 0 ? "float64" : "float32";
  return out;
}

void add_frames(py::module_& m) {
  py::class_<PyFrame, std::shared_ptr<PyFrame>> frame(
      m,
      "Frame",
      "What a sensor saw. Arrays are float32 [rows, columns], read-only, the frame's own memory: pixels of a "
      "picture, beams x firings of a sweep. Asking for one waits for the device.",
      made_objects_only());
  frame
      .def_property_readonly(
          "sensor", [](const PyFrame& f) { return f.frame().sensor(); }, "what saw it")
      .def_property_readonly(
          "world_from_sensor",
          [](const PyFrame& f) { return array_of(f.frame().shot().world_from_sensor_start); },
          "4 x 4, where the sensor was at the frame's start")
      .def_property_readonly(
          "world_from_sensor_end",
          [](const PyFrame& f) { return array_of(f.frame().shot().world_from_sensor_end); },
          "4 x 4, and at its end")
      .def_property_readonly(
          "span",
          [](const PyFrame& f) {
            return std::pair(f.frame().shot().time_start_s, f.frame().shot().time_end_s);
          },
          "when it starts and ends, s")
      .def("__repr__", &text_of)
      .def(
          "tensor",
          [](PyFrame& f, const std::string& name) {
            const auto is_it = [&](const auto& of) { return name == of.first; };
            if (std::any_of(std::begin(kArrays), std::end(kArrays), is_it)) return f.tensor(name);
            throw Error(ErrorKind::kUsage, "tensor: found \"" + name + "\", allowed the name of an array");
          },
          py::arg("name"),
          "An array's memory for `from_dlpack()` of torch, JAX or NumPy, without a copy: float32 on the "
          "host. It belongs to the frame and is read-only, which only DLPack 1 can express.")
      .def(
          "__dlpack__",
          [](PyFrame& f, const py::kwargs& requested) {
            return main_tensor(f).attr("__dlpack__")(**requested);
          },
          "That of tensor(\"image\"), of LiDARs tensor(\"range_m\").")
      .def(
          "__dlpack_device__",
          [](PyFrame& f) { return main_tensor(f).attr("__dlpack_device__")(); },
          "The host's.")
      .def_property_readonly(
          "is_ready",
          [](const PyFrame& f) {
            const DeviceLock lock = f.lock();
            return f.frame().is_ready();
          },
          "whether its results can be had without waiting")
      .def(
          "wait",
          [](const PyFrame& f) {
            const DeviceLock lock = f.lock();
            f.wait();
            f.frame().wait();
          },
          "Until the device has made it.")
      .def(
          "fetch",
          [](const PyFrame& f) {
            const DeviceLock lock = f.lock();
            f.frame().fetch();
          },
          "Starts bringing its results to the host; does not wait.")
      .def_property_readonly("points_m",
                             &PyFrame::points,
                             "float64 [beams, firings, 3] in the world; without a return the ray's origin")
      .def("cloud",
           &PyFrame::cloud,
           py::arg("frame") = "world",
           "The rays that returned, as `simuli render` writes them: a dict of xyz (float64 [n, 3], in the "
           "frame \"world\", \"sensor\", at each ray's own time, or \"sensor_start\", at the frame's start), "
           "intensity, range, drop, time (s since the start; float32 [n]) and, of LiDARs with rows, ring "
           "(uint16 [n])")
      .def_property_readonly(
          "actors",
          [](PyFrame& f) { return values(f, "actors").attr("astype")("uint32"); },
          "uint32 [rows, columns], of frames rendered with actors=True: 1 + the place in scene.actors of "
          "whose "
          "particle takes a ray's light below a half; 0: none's")
      .def_property_readonly("memory",
                             &PyFrame::memory,
                             "OpenCL handles as numbers, alive as long as the frame: outputs [6][slots] "
                             "(features, transmittance, distance_sum, median), of LiDARs [7][slots] (and the "
                             "logit of drop), picture [3][slots] or None, "
                             "ray_of_slot, slot_of_ray (int32), ready (event); slots, rays, dtype");
  for (const auto& [name, text] : kArrays) {
    frame.def_property_readonly(
        name, [name = std::string(name)](PyFrame& f) { return values(f, name); }, text);
  }
}

}  // namespace simuli::python
