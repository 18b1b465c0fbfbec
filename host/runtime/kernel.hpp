#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/runtime/buffer.hpp"
#include "host/runtime/program.hpp"
#include "host/runtime/real_buffer.hpp"

namespace simuli {

/// The name OpenCL C has for T, as the kernel's argument is declared. Structs of cl/shared are
/// registered beside the launcher: template <> struct ClTypeName<LidarParams> {
///   static constexpr std::string_view value = "LidarParams"; };
template <class T>
struct ClTypeName;
#define SIMULI_CL_TYPE(type, name)                  \
  template <>                                       \
  struct ClTypeName<type> {                         \
    static constexpr std::string_view value = name; \
  }
SIMULI_CL_TYPE(float, "float");
SIMULI_CL_TYPE(double, "double");
SIMULI_CL_TYPE(std::int8_t, "char");
SIMULI_CL_TYPE(std::uint8_t, "uchar");
SIMULI_CL_TYPE(std::int16_t, "short");
SIMULI_CL_TYPE(std::uint16_t, "ushort");
SIMULI_CL_TYPE(std::int32_t, "int");
SIMULI_CL_TYPE(std::uint32_t, "uint");
SIMULI_CL_TYPE(std::int64_t, "long");
SIMULI_CL_TYPE(std::uint64_t, "ulong");
#undef SIMULI_CL_TYPE

/// Global or local size: one to three dimensions, or Range::none() (the driver picks the local size).
class Range {
 public:
  // Implicit, so that launches read kernel.launch(count, 64, ...) and kernel.launch({w, h}, {16, 16}, ...).
  Range(std::size_t x) : size_{x, 1, 1}, dimensions_(1) {}  // NOLINT(google-explicit-constructor)
  Range(std::size_t x, std::size_t y) : size_{x, y, 1}, dimensions_(2) {}
  Range(std::size_t x, std::size_t y, std::size_t z) : size_{x, y, z}, dimensions_(3) {}
  [[nodiscard]] static Range none() { return {}; }

  [[nodiscard]] cl_uint dimensions() const { return dimensions_; }
  [[nodiscard]] const std::size_t* data() const { return dimensions_ == 0 ? nullptr : size_.data(); }
  [[nodiscard]] bool empty() const {
    return dimensions_ != 0 && (size_[0] == 0 || size_[1] == 0 || size_[2] == 0);
  }
  /// "640 x 360", or "any".
  [[nodiscard]] std::string text() const;

 private:
  Range() = default;
  std::array<std::size_t, 3> size_{1, 1, 1};
  cl_uint dimensions_ = 0;
};

/// The least multiple of `step` (> 0) that is >= count: global sizes are multiples of the local size.
[[nodiscard]] constexpr std::size_t round_up(std::size_t count, std::size_t step) {
  return count / step * step + (count % step == 0 ? 0 : step);
}

// Markers of kernel arguments, for Kernel<...>. Scalars and shared structs are named by their own type.
/// __global T*: takes a Buffer<T>&; Buf<const T> is a const __global T* and takes a const Buffer<T>&.
template <class T>
struct Buf {};
/// __global real*: takes a RealBuffer& of the program's precision.
struct BufReal {};
/// const __global real*.
struct BufRealConst {};
/// const __global T*, T a struct of reals (cl/shared/sensor_constants.h): takes a RealBuffer that holds some.
template <template <class> class T>
struct BufStructConst {};
/// real by value: takes a double, passed as the program's precision.
struct RealScalar {};
/// __local T*: takes the number of bytes.
struct Local {
  std::size_t bytes = 0;
};

namespace detail {

enum class ArgumentSpace { kValue, kGlobal, kLocal };

/// What the host passes for one argument.
struct ArgumentSpec {
  std::string type;  // "uint*"; "real" for the program's precision; empty: any
  ArgumentSpace space = ArgumentSpace::kValue;
  bool is_const = false;
};

/// The untyped part of Kernel<Args...>.
class KernelCore {
 public:
  KernelCore(const Program& program, std::string name, const std::vector<ArgumentSpec>& arguments);

  void set_value(cl_uint index, const void* value, std::size_t bytes);
  void set_real(cl_uint index, double value);
  void set_local(cl_uint index, std::size_t bytes);
  void set_memory(cl_uint index, const Memory& memory);
  void set_real_buffer(cl_uint index, const RealBuffer& buffer);
  void run(const Range& global, const Range& local);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Device& device() const { return program_.device(); }
  [[nodiscard]] const Program& program() const { return program_; }
  [[nodiscard]] std::size_t max_local_size() const;

 private:
  Program program_;
  std::string name_;
  cl::Kernel kernel_;
};

template <class T>
struct Argument {
  static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T> && !std::is_same_v<T, bool>);
  using Passed = const T&;
  static ArgumentSpec spec() { return {std::string(ClTypeName<T>::value), ArgumentSpace::kValue, false}; }
  static void set(KernelCore& kernel, cl_uint index, const T& value) {
    kernel.set_value(index, &value, sizeof(T));
  }
};
template <class T>
struct Argument<Buf<T>> {
  using Element = std::remove_const_t<T>;
  using Passed = std::conditional_t<std::is_const_v<T>, const Buffer<Element>&, Buffer<Element>&>;
  static ArgumentSpec spec() {
    return {std::string(ClTypeName<Element>::value) + "*", ArgumentSpace::kGlobal, std::is_const_v<T>};
  }
  static void set(KernelCore& kernel, cl_uint index, Passed buffer) {
    kernel.set_memory(index, buffer.memory());
  }
};
template <>
struct Argument<BufReal> {
  using Passed = RealBuffer&;
  static ArgumentSpec spec() { return {"real*", ArgumentSpace::kGlobal, false}; }
  static void set(KernelCore& kernel, cl_uint index, Passed buffer) { kernel.set_real_buffer(index, buffer); }
};
template <>
struct Argument<BufRealConst> {
  using Passed = const RealBuffer&;
  static ArgumentSpec spec() { return {"real*", ArgumentSpace::kGlobal, true}; }
  static void set(KernelCore& kernel, cl_uint index, Passed buffer) { kernel.set_real_buffer(index, buffer); }
};
template <template <class> class T>
struct Argument<BufStructConst<T>> {
  using Passed = const RealBuffer&;
  static ArgumentSpec spec() {
    return {std::string(ClTypeName<T<double>>::value) + "*", ArgumentSpace::kGlobal, true};
  }
  static void set(KernelCore& kernel, cl_uint index, Passed buffer) { kernel.set_real_buffer(index, buffer); }
};
template <>
struct Argument<RealScalar> {
  using Passed = double;
  static ArgumentSpec spec() { return {"real", ArgumentSpace::kValue, false}; }
  static void set(KernelCore& kernel, cl_uint index, double value) { kernel.set_real(index, value); }
};
template <>
struct Argument<Local> {
  using Passed = Local;
  static ArgumentSpec spec() { return {"", ArgumentSpace::kLocal, false}; }
  static void set(KernelCore& kernel, cl_uint index, Local local) { kernel.set_local(index, local.bytes); }
};

}  // namespace detail

/// A kernel whose launches are checked twice: by the C++ compiler against Args, and Args once, here,
/// against what the driver says of the kernel (Error{kKernel}; a driver without argument info has only
/// their number checked). Move-only: OpenCL keeps the arguments in the kernel object.
///   Kernel<Buf<const float>, Buf<std::uint32_t>, std::uint32_t> histogram(program, "histogram");
///   histogram.launch(round_up(n, 64), 64, range, counts, n);
template <class... Args>
class Kernel {
 public:
  Kernel(const Program& program, std::string name)
      : core_(program, std::move(name), {detail::Argument<Args>::spec()...}) {}
  Kernel(Kernel&&) noexcept = default;
  Kernel& operator=(Kernel&&) noexcept = default;
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;
  ~Kernel() = default;

  /// Queues the kernel; does not wait. A global size of 0 in any dimension launches nothing.
  /// Error{kKernel} naming kernel, global and local size when the driver refuses.
  void launch(const Range& global, const Range& local, typename detail::Argument<Args>::Passed... args) {
    if (global.empty()) return;
    set(std::index_sequence_for<Args...>(), args...);
    core_.run(global, local);
  }

  [[nodiscard]] const std::string& name() const { return core_.name(); }
  /// Largest local size the device runs this kernel with.
  [[nodiscard]] std::size_t max_local_size() const { return core_.max_local_size(); }

 private:
  template <std::size_t... I>
  void set(std::index_sequence<I...>, typename detail::Argument<Args>::Passed... args) {
    (detail::Argument<Args>::set(core_, static_cast<cl_uint>(I), args), ...);
  }

  detail::KernelCore core_;
};

}  // namespace simuli
