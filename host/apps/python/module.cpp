// import simuli: the library in Python. Arrays are NumPy's, of any version. The Python package is
// host/apps/python/simuli; its __init__.pyi declares the types.
#include <atomic>
#include <chrono>
#include <thread>
#include <unistd.h>

#include "host/apps/python/bindings.hpp"

namespace simuli::python {
namespace {

std::atomic<bool> is_leaving{false};
std::atomic<int> outside{0};  // threads that have released the GIL and will take it again
std::thread::id leaver;

bool is_left_behind() { return is_leaving && std::this_thread::get_id() != leaver; }

}  // namespace

GilRelease::GilRelease() {
  ++outside;
  state_ = PyEval_SaveThread();
}

GilRelease::~GilRelease() {
  if (is_left_behind()) {
    --outside;
    for (;;) ::pause();
  }
  PyEval_RestoreThread(state_);
  --outside;
}

const std::function<void()>& signals() {
  static const std::function<void()> check = [] {
    using Clock = std::chrono::steady_clock;
    thread_local Clock::time_point last;
    if (Clock::now() - last < std::chrono::milliseconds(100)) return;
    last = Clock::now();
    if (is_leaving)
      throw Error(ErrorKind::kUsage, "found an interpreter that is leaving, allowed one that stays");
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  };
  return check;
}

void GilRelease::watch_exit() {
  // A forked child does not have the other threads.
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") =
                                                         py::cpp_function([] { outside = 0; }));
  py::module_::import("atexit").attr("register")(py::cpp_function([] {
    leaver = std::this_thread::get_id();
    is_leaving = true;
    const py::gil_scoped_release release;
    while (outside > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }));
}

}  // namespace simuli::python

PYBIND11_MODULE(_simuli, m) {
  namespace py = pybind11;
  m.attr("__module__") = "simuli";  // the name that users and help() see
  m.doc() = "Camera and LiDAR simulation with 3D Gaussians on any OpenCL device";
  m.attr("__version__") = simuli::version();
  static const py::object error = py::exception<simuli::Error>(m, "Error", PyExc_RuntimeError);
  // Messages of MemoryError and others are those of the C++ exceptions.
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(std::move(thrown));
    } catch (const simuli::Error& reported) {
      PyErr_SetString(error.ptr(), reported.what());
    }
  });
  error.attr("__module__") = "simuli";
  error.attr("__doc__") =
      "What is raised: one line that names the file or the argument, what was found and what is allowed.";
  simuli::python::GilRelease::watch_exit();
  simuli::python::add_arrays(m);
  simuli::python::add_devices(m);
  simuli::python::add_sensors(m);
  simuli::python::add_frames(m);
  simuli::python::add_logs(m);
  simuli::python::add_scenes(m);
  simuli::python::add_training(m);
}
