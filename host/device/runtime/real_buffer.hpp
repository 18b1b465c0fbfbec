#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "host/device/runtime/buffer.hpp"
#include "host/device/runtime/build_options.hpp"

namespace simuli {

/// An array for kernel arguments of type `real`: float or double, chosen at run time. Host values of the other
/// type are rounded to nearest. Rules and errors as for Buffer<T>.
class RealBuffer {
 public:
  RealBuffer(const Device& device, const std::string& name, Precision precision, std::size_t count = 0);

  [[nodiscard]] Precision precision() const {
    return std::holds_alternative<Buffer<float>>(buffer_) ? Precision::kFloat : Precision::kDouble;
  }

  void reserve(std::size_t count);
  void upload(std::span<const float> values);
  void upload(std::span<const double> values);
  void assign(std::span<const float> values);
  void assign(std::span<const double> values);
  [[nodiscard]] std::vector<float> download_float() const;
  [[nodiscard]] std::vector<double> download_double() const;
  void fill(double value);
  /// Copies on the device; precision and count must be the same.
  void copy_from(const RealBuffer& source);
  /// Swaps the content with that of `other`, of the same precision, without a copy; each keeps its name.
  void exchange(RealBuffer& other) noexcept { memory().exchange(other.memory()); }

  [[nodiscard]] std::size_t count() const { return memory().count(); }
  [[nodiscard]] std::size_t capacity() const { return memory().capacity(); }
  [[nodiscard]] const std::string& name() const { return memory().name(); }
  [[nodiscard]] const detail::Memory& memory() const;
  [[nodiscard]] detail::Memory& memory();

  /// Returns the typed buffer. Throws Error{kInternal} when the precision differs.
  [[nodiscard]] Buffer<float>& as_float();
  [[nodiscard]] const Buffer<float>& as_float() const;
  [[nodiscard]] Buffer<double>& as_double();
  [[nodiscard]] const Buffer<double>& as_double() const;

 private:
  std::variant<Buffer<float>, Buffer<double>> buffer_;
};

/// An array of structs of `real`s (cl/shared/reals.h) for kernel arguments of type T. Counts and values refer to
/// single reals: shared::kReals<T> and shared::reals_of().
template <template <class> class T>
class StructBuffer : public RealBuffer {
 public:
  using RealBuffer::RealBuffer;
};

}  // namespace simuli
