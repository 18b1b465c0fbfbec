#pragma once
// Kernels, whose arguments are bound by the names that their own text gives them.
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "host/device/runtime/argument.hpp"
#include "host/device/runtime/buffer.hpp"
#include "host/device/runtime/program.hpp"
#include "host/device/runtime/real_buffer.hpp"

struct _cl_kernel;  // what a cl_kernel points to

namespace simuli {

/// Global or local size: one to three dimensions, or Range::none() (the driver picks the local size).
class Range {
 public:
  // Implicit, so that launches read kernel.run(count, 64, ...) and kernel.run({w, h}, {16, 16}, ...).
  Range(std::size_t x) : size_{x, 1, 1}, dimensions_(1) {}  // NOLINT(google-explicit-constructor)
  Range(std::size_t x, std::size_t y) : size_{x, y, 1}, dimensions_(2) {}
  Range(std::size_t x, std::size_t y, std::size_t z) : size_{x, y, z}, dimensions_(3) {}
  [[nodiscard]] static Range none() { return {}; }

  [[nodiscard]] std::uint32_t dimensions() const { return dimensions_; }
  [[nodiscard]] const std::size_t* data() const { return dimensions_ == 0 ? nullptr : size_.data(); }
  [[nodiscard]] bool empty() const {
    return dimensions_ != 0 && (size_[0] == 0 || size_[1] == 0 || size_[2] == 0);
  }
  /// "640 x 360", or "any".
  [[nodiscard]] std::string text() const;

 private:
  Range() = default;
  std::array<std::size_t, 3> size_{1, 1, 1};
  std::uint32_t dimensions_ = 0;
};

/// The least multiple of `step` (> 0) that is >= count: global sizes are multiples of the local size.
[[nodiscard]] constexpr std::size_t round_up(std::size_t count, std::size_t step) {
  return count / step * step + (count % step == 0 ? 0 : step);
}

class Kernel;

/// What binds several arguments at once: a group of buffers that are known by the same names everywhere.
template <class T>
concept ArgumentGroup = requires(T& group, Kernel& kernel) {
  group.offer_to(kernel);
};

/// One argument, or a group of them, for one launch: refers to buffers and groups, and has values by itself.
class Binding {
 public:
  /// __global T*, of a const Buffer const __global T*.
  template <class T>
  Binding(ArgumentName name, Buffer<T>& buffer)
      : name_(name.text()), type_(&detail::kPassedBuffer<T>), memory_(&buffer.memory()) {}
  template <class T>
  Binding(ArgumentName name, const Buffer<T>& buffer)
      : name_(name.text()), type_(&detail::kPassedBuffer<const T>), memory_(&buffer.memory()) {}
  /// __global real*, of a const RealBuffer const __global real*; of the program's precision.
  Binding(ArgumentName name, RealBuffer& buffer)
      : name_(name.text()), type_(&type_of(buffer)), memory_(&buffer.memory()) {}
  Binding(ArgumentName name, const RealBuffer& buffer)
      : name_(name.text()), type_(&type_of(buffer)), memory_(&buffer.memory()) {}
  /// __global T*, T a struct of reals, likewise.
  template <template <class> class T>
  Binding(ArgumentName name, StructBuffer<T>& buffer)
      : name_(name.text()), type_(&type_of<T<double>>(buffer)), memory_(&buffer.memory()) {}
  template <template <class> class T>
  Binding(ArgumentName name, const StructBuffer<T>& buffer)
      : name_(name.text()), type_(&type_of<const T<double>>(buffer)), memory_(&buffer.memory()) {}
  /// real by value, passed in the program's precision.
  Binding(ArgumentName name, double value) : name_(name.text()), type_(&detail::kPassedReal), real_(value) {}
  /// Integers, float and shared structs by value.
  template <class T>
  requires(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T> && !std::is_same_v<T, bool> &&
           !std::is_same_v<T, double>) Binding(ArgumentName name, const T& value)
      : name_(name.text()), type_(&detail::kPassedValue<T>), bytes_(sizeof(T)) {
    static_assert(sizeof(T) <= kMostBytes);
    std::memcpy(value_.data(), &value, sizeof(T));
  }
  Binding(ArgumentName name, const Local& local)
      : name_(name.text()), type_(&detail::kPassedLocal), bytes_(local.bytes) {}
  /// Those of the group's members that the kernel has an argument for; of a const group they are const.
  template <ArgumentGroup T>
  Binding(T& group)  // NOLINT(google-explicit-constructor)
      : group_(&group), offer_([](const void* g, Kernel& kernel) {
          static_cast<T*>(const_cast<void*>(g))->offer_to(kernel);
        }) {}

  [[nodiscard]] static const detail::PassedType& type_of(RealBuffer& buffer) {
    return buffer.precision() == Precision::kFloat ? detail::kPassedBuffer<float>
                                                   : detail::kPassedBuffer<double>;
  }
  [[nodiscard]] static const detail::PassedType& type_of(const RealBuffer& buffer) {
    return buffer.precision() == Precision::kFloat ? detail::kPassedBuffer<const float>
                                                   : detail::kPassedBuffer<const double>;
  }

  template <class Struct>
  [[nodiscard]] static const detail::PassedType& type_of(const RealBuffer& structs) {
    return structs.precision() == Precision::kFloat ? detail::kPassedStructs<Struct, float>
                                                    : detail::kPassedStructs<Struct, double>;
  }

 private:
  friend class Kernel;
  static constexpr std::size_t kMostBytes = 64;
  const char* name_ = nullptr;
  const detail::PassedType* type_ = nullptr;
  const detail::Memory* memory_ = nullptr;
  std::size_t bytes_ = 0;
  alignas(16) std::array<std::byte, kMostBytes> value_{};
  double real_ = 0.0;
  const void* group_ = nullptr;
  void (*offer_)(const void*, Kernel&) = nullptr;
};

/// A kernel of a program. Every launch binds every argument once, by the name that the kernel's text gives
/// it; types, const and address space are compared with the text's. What is missing, unknown, bound twice or
/// of another type is Error{kKernel} naming kernel and argument, at the first launch with that list. Later
/// launches with the same list compare addresses. Move-only: OpenCL keeps the arguments in the kernel object.
///   Kernel histogram(program, "histogram");
///   histogram.run(round_up(n, 64), 64, {{"values", values}, {"counts", counts}, {"n", n}});
class Kernel {
 public:
  Kernel(const Program& program, std::string name);

  /// Queues the kernel; does not wait. A global size of 0 in any dimension launches nothing.
  /// Error{kKernel} naming kernel, global and local size when the driver refuses; Error{kInternal} for a
  /// buffer of another device.
  void run(const Range& global, const Range& local, std::initializer_list<Binding> arguments);
  /// The same for at least `count` work-items that have nothing in common, in groups that suit the device and
  /// that it runs this kernel with: whole waves on GPUs. Those beyond `count` must do nothing.
  void run_over(std::size_t count, std::initializer_list<Binding> arguments);

  /// For ArgumentGroup::offer_to(): binds what the kernel has an argument for. `name`: a literal's address.
  void offer(const char* name, const detail::PassedType& type, const detail::Memory& memory);

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Largest local size the device runs this kernel with.
  [[nodiscard]] std::size_t max_local_size() const;

 private:
  struct Release {
    void operator()(_cl_kernel* kernel) const noexcept;
  };
  /// Where the last list's bindings went, in their order; kUnused: a group's that has no argument here.
  struct ArgumentSlot {
    const char* name = nullptr;
    const detail::PassedType* type = nullptr;
    std::uint32_t index = 0;
  };
  static constexpr std::uint32_t kUnused = 0xffffffffU;

  std::uint32_t slot_of(const char* name, const detail::PassedType& type, bool offered);
  std::uint32_t find_slot(const char* name, const detail::PassedType& type, bool offered) const;
  void need_all() const;
  void bind(const Binding& binding);
  void set(std::uint32_t index, std::size_t bytes, const void* value);
  void set_memory(std::uint32_t index, const detail::Memory& memory);
  void enqueue(const Range& global, const Range& local);

  Program program_;
  std::string name_;
  std::unique_ptr<_cl_kernel, Release> kernel_;
  const KernelDeclaration* declaration_;  // of the program
  std::size_t group_ = 0;                 // of run_over(); 0: not asked yet
  std::vector<ArgumentSlot> slots_;
  std::size_t at_ = 0;        // of the launch under way
  bool is_complete_ = false;  // slots_ has every argument once
};

}  // namespace simuli
