// import simuli: what the library does, from Python. Arrays are NumPy's, of any version. The package around
// it is host/apps/python/simuli; its __init__.pyi has the types.
#include "host/apps/python/bindings.hpp"

PYBIND11_MODULE(_simuli, m) {
  namespace py = pybind11;
  m.attr("__module__") = "simuli";  // where users find what follows, and what help() calls it
  m.doc() = "Camera and LiDAR simulation with 3D Gaussians on any OpenCL device";
  m.attr("__version__") = simuli::version();
  py::object error = py::register_exception<simuli::Error>(m, "Error", PyExc_RuntimeError);
  error.attr("__module__") = "simuli";
  error.attr("__doc__") =
      "What is raised: one line that names the file or the argument, what was found and what is allowed.";
  simuli::python::add_arrays(m);
  simuli::python::add_devices(m);
  simuli::python::add_sensors(m);
  simuli::python::add_frames(m);
  simuli::python::add_scenes(m);
  simuli::python::add_training(m);
}
