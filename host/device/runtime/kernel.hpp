#pragma once
// Kernels. Launches bind arguments by the names in the kernel text.
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

struct _cl_kernel;  // the object behind a cl_kernel

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

/// A group of buffers with fixed argument names that one binding passes together.
template <class T>
concept ArgumentGroup = requires(T& group, Kernel& kernel) {
  group.offer_to(kernel);
};

/// One argument or one group of arguments of a launch. Refers to buffers and groups; stores values.
class Binding {
 public:
  /// Binds `__global T*`, and `const __global T*` for a const Buffer.
  template <class T>
  Binding(ArgumentName name, Buffer<T>& buffer)
      : name_(name.text()), type_(&detail::kPassedBuffer<T>), memory_(&buffer.memory()) {}
  template <class T>
  Binding(ArgumentName name, const Buffer<T>& buffer)
      : name_(name.text()), type_(&detail::kPassedBuffer<const T>), memory_(&buffer.memory()) {}
  /// Binds `__global real*`, and `const __global real*` for a const RealBuffer, of the program's precision.
  Binding(ArgumentName name, RealBuffer& buffer)
      : name_(name.text()), type_(&type_of(buffer)), memory_(&buffer.memory()) {}
  Binding(ArgumentName name, const RealBuffer& buffer)
      : name_(name.text()), type_(&type_of(buffer)), memory_(&buffer.memory()) {}
  /// Binds `__global T*` for a struct T of reals, const likewise.
  template <template <class> class T>
  Binding(ArgumentName name, StructBuffer<T>& buffer)
      : name_(name.text()), type_(&type_of<T<double>>(buffer)), memory_(&buffer.memory()) {}
  template <template <class> class T>
  Binding(ArgumentName name, const StructBuffer<T>& buffer)
      : name_(name.text()), type_(&type_of<const T<double>>(buffer)), memory_(&buffer.memory()) {}
  /// Binds a `real` by value, converted to the program's precision.
  Binding(ArgumentName name, double value) : name_(name.text()), type_(&detail::kPassedReal), real_(value) {}
  /// Binds integers, float and shared structs by value.
  template <class T>
  requires(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T> && !std::is_same_v<T, bool> &&
           !std::is_same_v<T, double>) Binding(ArgumentName name, const T& value)
      : name_(name.text()), type_(&detail::kPassedValue<T>), bytes_(sizeof(T)) {
    static_assert(sizeof(T) <= kMostBytes);
    std::memcpy(value_.data(), &value, sizeof(T));
  }
  Binding(ArgumentName name, const Local& local)
      : name_(name.text()), type_(&detail::kPassedLocal), bytes_(local.bytes) {}
  /// Binds the members of the group that are arguments of the kernel; members of a const group are const.
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

/// A kernel of a program. Every launch binds every argument once, by its name in the kernel text; types, const
/// and address space are checked against the text. A missing, unknown, repeated or wrongly typed argument throws
/// Error{kKernel} with kernel and argument at the first launch with that list. Later launches with the same list
/// only compare addresses. Move-only: OpenCL stores the arguments in the kernel object.
///   Kernel histogram(program, "histogram");
///   histogram.run(round_up(n, 64), 64, {{"values", values}, {"counts", counts}, {"n", n}});
class Kernel {
 public:
  Kernel(const Program& program, std::string name);

  /// Queues the kernel; does not wait. A global size of 0 in any dimension launches nothing. Throws
  /// Error{kKernel} with kernel, global and local size when the driver refuses the launch, and Error{kInternal}
  /// for a buffer of another device.
  void run(const Range& global, const Range& local, std::initializer_list<Binding> arguments);
  /// Queues at least `count` independent work-items in groups that suit the device: whole waves on GPUs.
  /// Work-items beyond `count` must do nothing.
  void run_over(std::size_t count, std::initializer_list<Binding> arguments);

  /// For ArgumentGroup::offer_to(): binds the member if the kernel has an argument of that name. `name` is a
  /// literal's address.
  void offer(const char* name, const detail::PassedType& type, const detail::Memory& memory);

  [[nodiscard]] const std::string& name() const { return name_; }
  /// The largest local size that the device supports for this kernel.
  [[nodiscard]] std::size_t max_local_size() const;

 private:
  struct Release {
    void operator()(_cl_kernel* kernel) const noexcept;
  };
  /// Argument index of each binding of the last list; kUnused for a group's member without an argument.
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
  const KernelDeclaration* declaration_;  // owned by the program
  std::size_t group_ = 0;                 // group size of run_over(); 0: not determined yet
  std::vector<ArgumentSlot> slots_;
  std::size_t at_ = 0;        // next binding of the current launch
  bool is_complete_ = false;  // slots_ contains every argument once
};

}  // namespace simuli
