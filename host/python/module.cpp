// import simuli: what the library does, from Python. Arrays are NumPy's, of any version.
#include "host/python/bindings.hpp"

PYBIND11_MODULE(simuli, m) {
  namespace py = pybind11;
  m.doc() = "Camera and LiDAR simulation with 3D Gaussians on any OpenCL device";
  m.attr("__version__") = simuli::version();
  py::register_exception<simuli::Error>(m, "Error", PyExc_RuntimeError);
  simuli::python::add_arrays(m);
  simuli::python::add_devices(m);
  simuli::python::add_sensors(m);
  simuli::python::add_frames(m);
  simuli::python::add_scenes(m);
  simuli::python::add_training(m);
}
