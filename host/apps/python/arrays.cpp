// Arrays from and to Python by the buffer protocol.
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "host/apps/python/bindings.hpp"

namespace simuli::python {
namespace {

/// Memory of the module that Python may read.
struct View {
  std::shared_ptr<const void> owner;
  const void* data;
  std::string format;  // as in the module `struct`
  py::ssize_t item_bytes;
  std::vector<py::ssize_t> shape, strides;
};

std::string shape_text(const std::vector<py::ssize_t>& shape) {
  std::string text;
  for (const py::ssize_t n : shape) text += (text.empty() ? "" : " x ") + std::to_string(n);
  return text.empty() ? "one number" : text;
}

py::object object_of(View view) {
  if (view.strides.empty()) {
    py::ssize_t bytes = view.item_bytes;
    view.strides.resize(view.shape.size());
    for (std::size_t i = view.shape.size(); i-- > 0;) {
      view.strides[i] = bytes;
      bytes *= view.shape[i];
    }
  }
  return py::cast(std::move(view));
}

py::object numpy_array(View view) {
  return py::module_::import("numpy").attr("asarray")(object_of(std::move(view)));
}

// Structures of the DLPack specification: unversioned, and version 1, which has a read-only flag.
struct DlTensor {
  void* data;
  std::int32_t device_type, device_id;
  std::int32_t dimensions;
  std::uint8_t type_code, type_bits;
  std::uint16_t type_lanes;
  std::int64_t* shape;
  std::int64_t* strides;  // in elements
  std::uint64_t byte_offset;
};
struct DlManaged {
  DlTensor tensor;
  void* context;
  void (*deleter)(DlManaged*);
};
struct DlManagedVersioned {
  std::uint32_t major, minor;
  void* context;
  void (*deleter)(DlManagedVersioned*);
  std::uint64_t flags;
  DlTensor tensor;
};
constexpr std::int32_t kDlHost = 1;
constexpr std::uint8_t kDlFloat = 2;
constexpr std::uint64_t kDlReadOnly = 1;

/// Content of a capsule: the structure and the arrays that it points to.
template <class Managed>
struct DlHolder {
  Managed managed{};
  View view;
  std::vector<std::int64_t> shape, strides;
};

/// Names of capsules that no consumer has taken.
const char* name_of(const DlManaged*) { return "dltensor"; }
const char* name_of(const DlManagedVersioned*) { return "dltensor_versioned"; }

template <class Managed>
py::object dlpack_capsule(const View& view) {
  auto holder = std::make_unique<DlHolder<Managed>>();
  holder->view = view;
  holder->shape.assign(view.shape.begin(), view.shape.end());
  for (const py::ssize_t bytes : view.strides) holder->strides.push_back(bytes / view.item_bytes);
  Managed& managed = holder->managed;
  managed.context = holder.get();
  managed.deleter = [](Managed* of) {
    if (Py_IsInitialized() == 0) return;  // a consumer may outlive the interpreter
    const py::gil_scoped_acquire acquire;
    delete static_cast<DlHolder<Managed>*>(of->context);
  };
  managed.tensor = {const_cast<void*>(view.data),
                    kDlHost,
                    0,
                    static_cast<std::int32_t>(view.shape.size()),
                    kDlFloat,
                    static_cast<std::uint8_t>(8 * view.item_bytes),
                    1,
                    holder->shape.data(),
                    holder->strides.data(),
                    0};
  if constexpr (std::is_same_v<Managed, DlManagedVersioned>) {
    managed.major = 1;
    managed.flags = kDlReadOnly;
  }
  PyObject* const capsule = PyCapsule_New(&managed, name_of(&managed), [](PyObject* of) {
    constexpr const Managed* kKind = nullptr;
    if (PyCapsule_IsValid(of, name_of(kKind)) == 0) return;  // a consumer has taken it
    auto* const untaken = static_cast<Managed*>(PyCapsule_GetPointer(of, name_of(kKind)));
    untaken->deleter(untaken);
  });
  if (capsule == nullptr) throw py::error_already_set();
  static_cast<void>(holder.release());
  return py::reinterpret_steal<py::object>(capsule);
}

/// Implements the array API's __dlpack__().
py::object dlpack(const View& view,
                  const py::object& stream,
                  const std::optional<std::pair<int, int>>& max_version,
                  const std::optional<std::pair<int, int>>& dl_device,
                  std::optional<bool> copy) {
  const auto refuse = [](const char* text) {
    PyErr_SetString(PyExc_BufferError, text);
    throw py::error_already_set();
  };
  if (!stream.is_none()) refuse("stream: found one, allowed None: the values are the host's");
  if (dl_device && *dl_device != std::pair(kDlHost, 0)) refuse("dl_device: allowed (1, 0), the host's");
  if (copy == true) refuse("copy: found True, allowed False or None: copy what you take");
  return max_version && max_version->first >= 1 ? dlpack_capsule<DlManagedVersioned>(view)
                                                : dlpack_capsule<DlManaged>(view);
}

/// `rows`: 3, or 4 with the last row 0 0 0 1.
Pose pose_at(const double* row_major, py::ssize_t rows, const std::string& what) {
  for (py::ssize_t i = 0; i < 4 * rows; ++i) finite(row_major[i], what.c_str());
  constexpr double kSlack = 1e-5;  // for single precision
  const Eigen::Vector4d last = rows < 4 ? Eigen::Vector4d::UnitW() : Eigen::Vector4d(row_major + 12);
  if ((last - Eigen::Vector4d::UnitW()).cwiseAbs().maxCoeff() > kSlack) {
    std::string found;
    for (const double number : last) found += " " + py::str(py::float_(number)).cast<std::string>();
    throw Error(ErrorKind::kInput,
                what + ": found a last row of" + found + ", allowed 0 0 0 1 (is it transposed?)");
  }
  return Pose::from_matrix(Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(row_major));
}

}  // namespace

double finite(double value, const char* what) {
  if (std::isfinite(value)) return value;
  throw Error(ErrorKind::kUsage, std::string(what) + ": found NaN or infinity, allowed finite");
}

Numbers numbers_of(const py::handle& from, const std::string& what) {
  const py::module_ numpy = py::module_::import("numpy");
  py::object array;
  std::string kind;
  try {
    array = numpy.attr("asarray")(from);
    kind = array.attr("dtype").attr("kind").cast<std::string>();
  } catch (py::error_already_set&) {  // ragged lists
    kind = "O";
  }
  if (kind != "f" && kind != "i" && kind != "u" && kind != "b") {
    throw Error(ErrorKind::kUsage, what + ": found something else, allowed an array of real numbers");
  }
  array = numpy.attr("ascontiguousarray")(array, "float64");
  const py::buffer_info info = py::reinterpret_borrow<py::buffer>(array).request();
  const auto* const first = static_cast<const double*>(info.ptr);
  return {{first, first + info.size}, info.shape};
}

Pose pose_of(const py::handle& from, const std::string& what) {
  const Numbers matrix = numbers_of(from, what);
  if (matrix.shape.size() != 2 || matrix.shape[0] < 3 || matrix.shape[0] > 4 || matrix.shape[1] != 4) {
    throw Error(ErrorKind::kUsage, what + ": found " + shape_text(matrix.shape) + ", allowed 4 x 4 or 3 x 4");
  }
  return pose_at(matrix.values.data(), matrix.shape[0], what);
}

std::vector<Pose> poses_of(const py::handle& from, const std::string& what) {
  const Numbers stack = numbers_of(from, what);
  if (stack.shape.size() != 3 || stack.shape[1] < 3 || stack.shape[1] > 4 || stack.shape[2] != 4) {
    throw Error(ErrorKind::kUsage,
                what + ": found " + shape_text(stack.shape) + ", allowed n x 4 x 4 or n x 3 x 4");
  }
  std::vector<Pose> poses;
  for (py::ssize_t i = 0; i < stack.shape[0]; ++i) {
    poses.push_back(pose_at(stack.values.data() + i * stack.shape[1] * stack.shape[2], stack.shape[1], what));
  }
  return poses;
}

py::object tensor_on(std::shared_ptr<const void> owner, const float* data, std::vector<py::ssize_t> shape) {
  return object_of(
      {std::move(owner), data, py::format_descriptor<float>::format(), sizeof(float), std::move(shape), {}});
}

py::object array_on(std::shared_ptr<const void> owner,
                    const float* data,
                    std::vector<py::ssize_t> shape,
                    std::vector<py::ssize_t> strides) {
  return numpy_array({std::move(owner),
                      data,
                      py::format_descriptor<float>::format(),
                      sizeof(float),
                      std::move(shape),
                      std::move(strides)});
}

py::object array_on(std::shared_ptr<const void> owner, const double* data, std::vector<py::ssize_t> shape) {
  return numpy_array({std::move(owner),
                      data,
                      py::format_descriptor<double>::format(),
                      sizeof(double),
                      std::move(shape),
                      {}});
}

py::object array_of(const Pose& a_from_b) {
  using Matrix = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const auto matrix = std::make_shared<const Matrix>(a_from_b.matrix());
  return array_on(matrix, matrix->data(), {4, 4});
}

void add_arrays(py::module_& m) {
  py::class_<View>(m, "_View", py::buffer_protocol(), "Memory of the library's: a buffer, and DLPack's.")
      .def_buffer([](const View& view) {
        return py::buffer_info(const_cast<void*>(view.data),
                               view.item_bytes,
                               view.format,
                               static_cast<py::ssize_t>(view.shape.size()),
                               view.shape,
                               view.strides,
                               true);
      })
      .def("__dlpack_device__", [](const View&) { return std::pair(kDlHost, 0); })
      .def("__dlpack__",
           &dlpack,
           py::kw_only(),
           py::arg("stream") = py::none(),
           py::arg("max_version") = py::none(),
           py::arg("dl_device") = py::none(),
           py::arg("copy") = py::none());
}

}  // namespace simuli::python
