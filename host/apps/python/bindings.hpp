#pragma once
// Declarations that the module's sources share. NumPy is accessed through Python's buffer protocol only: its C
// interface differs between NumPy 1 and 2.
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <simuli/simuli.hpp>
#include <string>
#include <utility>
#include <vector>

namespace simuli::python {

namespace py = pybind11;

/// For each class: an object made by Class.__new__() alone has no attributes, instead of uninitialised memory.
[[nodiscard]] inline py::custom_type_setup made_objects_only() {
  return py::custom_type_setup([](PyHeapTypeObject* type) {
    type->ht_type.tp_getattro = [](PyObject* object, PyObject* name) -> PyObject* {
      auto* const kind = reinterpret_cast<PyObject*>(Py_TYPE(object));
      const bool is_made =
          reinterpret_cast<py::detail::instance*>(object)->get_value_and_holder().value_ptr() != nullptr;
      const char* const text = is_made ? nullptr : PyUnicode_AsUTF8(name);
      if (is_made || (text != nullptr && (text[0] == '_' || PyObject_HasAttr(kind, name) == 0))) {
        return PyObject_GenericGetAttr(object, name);
      }
      if (text != nullptr) {
        PyErr_Format(
            PyExc_TypeError, "%s: found an object that __init__() has not made", Py_TYPE(object)->tp_name);
      }
      return nullptr;
    };
  });
}

/// Held while a device is used: its calls release the GIL, so other threads could interfere.
using DeviceMutex = std::shared_ptr<std::recursive_timed_mutex>;

/// Releases the GIL during its lifetime. Threads that return while the interpreter shuts down block here,
/// because Python would end them by unwinding, which would end the process. At exit the interpreter waits for
/// all threads that have released the GIL, so that none is in the driver when it is unloaded.
class GilRelease {
 public:
  GilRelease();
  GilRelease(const GilRelease&) = delete;
  GilRelease& operator=(const GilRelease&) = delete;
  ~GilRelease();
  /// Called once, when the module is loaded.
  static void watch_exit();

 private:
  PyThreadState* state_;
};

/// Callback of an Interruption: throws the exception of Python's signal handlers (Ctrl-C), and Error{kUsage} in
/// a thread during the interpreter's shutdown. Takes the GIL ten times a second.
[[nodiscard]] const std::function<void()>& signals();

/// Releases the GIL, then locks the device during its lifetime. Recursive, so that a training's callback may
/// render. Does not lock in a forked child, where another thread may hold the lock forever. `is_heard`: Ctrl-C
/// interrupts the wait and the calls made meanwhile; destructors pass false.
class DeviceLock {
 public:
  explicit DeviceLock(const DeviceMutex& mutex, bool is_heard = true)
      : mutex_(mutex), lock_(*mutex_, std::defer_lock) {
    if (is_heard) interruption_.emplace(signals());
    while (!Device::is_forked() && !lock_.try_lock_for(std::chrono::milliseconds(100))) {
      if (is_heard) Interruption::ask();
    }
  }

 private:
  GilRelease release_;
  DeviceMutex mutex_;
  std::unique_lock<std::recursive_timed_mutex> lock_;
  std::optional<Interruption> interruption_;
};

struct PyDevice {
  Device device;
  DeviceMutex mutex = std::make_shared<std::recursive_timed_mutex>();
};
/// Accepts None (the best device), a text (Device::best()) or a Device.
[[nodiscard]] PyDevice device_of(const py::object& device);

// Arrays.

/// Numbers from any object that NumPy converts to an array. Throws Error{kUsage} naming `what` for an object
/// without numbers.
struct Numbers {
  std::vector<double> values;  // row-major
  std::vector<py::ssize_t> shape;
};
[[nodiscard]] Numbers numbers_of(const py::handle& from, const std::string& what);
/// Accepts a 4 x 4 or 3 x 4 matrix. Throws Error{kUsage} for another shape, Error{kInput} for a matrix that is
/// not a rigid transform or whose last row is not 0 0 0 1.
[[nodiscard]] Pose pose_of(const py::handle& from, const std::string& what);
/// Accepts [n, 4, 4] or [n, 3, 4].
[[nodiscard]] std::vector<Pose> poses_of(const py::handle& from, const std::string& what);
/// Throws Error{kUsage} naming `what` unless the value is finite.
double finite(double value, const char* what);

/// Returns memory of `owner` for NumPy and DLPack, without a copy.
[[nodiscard]] py::object tensor_on(std::shared_ptr<const void> owner,
                                   const float* data,
                                   std::vector<py::ssize_t> shape);
/// Returns a read-only NumPy array of memory of `owner`, without a copy.
[[nodiscard]] py::object array_on(std::shared_ptr<const void> owner,
                                  const float* data,
                                  std::vector<py::ssize_t> shape,
                                  std::vector<py::ssize_t> strides = {});
[[nodiscard]] py::object array_on(std::shared_ptr<const void> owner,
                                  const double* data,
                                  std::vector<py::ssize_t> shape);
[[nodiscard]] py::object array_of(const Pose& a_from_b);  // 4 x 4

/// Throws Error{kUsage} unless `edits` is a list of Edits.
[[nodiscard]] std::vector<ActorEdit> edits_of(const py::object& edits);

// Values that simuli.pyi declares as dicts.
[[nodiscard]] std::map<std::string, Sensor> sensors_of(const SensorRig& rig, bool cameras);
[[nodiscard]] std::map<std::string, std::vector<std::pair<double, double>>> spans_of(
    const FrameSpans& recorded);
[[nodiscard]] py::list actors_as_dicts(const std::vector<Actor>& actors);
[[nodiscard]] py::list labels_as_dicts(const std::vector<ActorLabel>& labels,
                                       const Scene& scene,
                                       bool is_camera);

// Parts of the module.
void add_arrays(py::module_& m);
void add_devices(py::module_& m);
void add_sensors(py::module_& m);
void add_frames(py::module_& m);
void add_logs(py::module_& m);
void add_scenes(py::module_& m);
void add_training(py::module_& m);

/// A frame in Python; arrays on its memory keep it alive.
class PyFrame : public std::enable_shared_from_this<PyFrame> {
 public:
  PyFrame(Frame frame, DeviceMutex mutex) : frame_(std::move(frame)), mutex_(std::move(mutex)) {}
  PyFrame(const PyFrame&) = delete;
  PyFrame& operator=(const PyFrame&) = delete;
  ~PyFrame();

  [[nodiscard]] const Frame& frame() const { return *frame_; }
  [[nodiscard]] DeviceLock lock() const { return DeviceLock(mutex_); }

  /// Waits until the device has rendered it; Ctrl-C interrupts. Call it with the device's lock.
  void wait() const;
  [[nodiscard]] py::object tensor(const std::string& name);
  [[nodiscard]] py::object points();
  [[nodiscard]] py::dict cloud(const std::string& in) const;
  [[nodiscard]] py::dict memory() const;

 private:
  [[nodiscard]] std::vector<float> computed(const std::string& name) const;

  std::optional<Frame> frame_;
  DeviceMutex mutex_;
  std::map<std::string, std::shared_ptr<const std::vector<float>>> computed_;
  std::shared_ptr<const std::vector<Eigen::Vector3d>> points_;
};

}  // namespace simuli::python
