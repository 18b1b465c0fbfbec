#include "host/device/runtime/real_buffer.hpp"

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

using Variant = std::variant<Buffer<float>, Buffer<double>>;

Variant make(const Device& device, const std::string& name, Precision precision, std::size_t count) {
  if (precision == Precision::kDouble) return Buffer<double>(device, name, count);
  return Buffer<float>(device, name, count);
}

template <class To, class From>
std::vector<To> converted(std::span<const From> values) {
  std::vector<To> out;
  out.reserve(values.size());
  for (const From value : values) out.push_back(static_cast<To>(value));
  return out;
}

template <class From>
void upload_to(Variant& variant, std::span<const From> values) {
  std::visit(
      [&]<class To>(Buffer<To>& buffer) {
        if constexpr (std::is_same_v<To, From>) {
          buffer.upload(values);
        } else {
          buffer.upload(converted<To>(values));
        }
      },
      variant);
}

template <class To>
std::vector<To> download_from(const Variant& variant) {
  return std::visit(
      []<class From>(const Buffer<From>& buffer) -> std::vector<To> {
        if constexpr (std::is_same_v<To, From>) {
          return buffer.download();
        } else {
          const std::vector<From> values = buffer.download();
          return converted<To>(std::span<const From>(values));
        }
      },
      variant);
}

template <class T, class V>
auto& typed(V& variant, const RealBuffer& buffer) {
  auto* const found = std::get_if<Buffer<T>>(&variant);
  if (found == nullptr) {
    throw Error(ErrorKind::kInternal, "buffer " + buffer.name() + " has the other precision");
  }
  return *found;
}

}  // namespace

RealBuffer::RealBuffer(const Device& device, const std::string& name, Precision precision, std::size_t count)
    : buffer_(make(device, name, precision, count)) {}

void RealBuffer::reserve(std::size_t count) {
  std::visit([&](auto& buffer) { buffer.reserve(count); }, buffer_);
}
void RealBuffer::upload(std::span<const float> values) { upload_to(buffer_, values); }
void RealBuffer::upload(std::span<const double> values) { upload_to(buffer_, values); }
void RealBuffer::assign(std::span<const float> values) {
  reserve(values.size());
  upload(values);
}
void RealBuffer::assign(std::span<const double> values) {
  reserve(values.size());
  upload(values);
}
std::vector<float> RealBuffer::download_float() const { return download_from<float>(buffer_); }
std::vector<double> RealBuffer::download_double() const { return download_from<double>(buffer_); }

void RealBuffer::fill(double value) {
  std::visit([&]<class T>(Buffer<T>& buffer) { buffer.fill(static_cast<T>(value)); }, buffer_);
}

void RealBuffer::copy_from(const RealBuffer& source) {
  if (precision() == Precision::kFloat) {
    as_float().copy_from(source.as_float());
  } else {
    as_double().copy_from(source.as_double());
  }
}

const detail::Memory& RealBuffer::memory() const {
  return std::visit([](const auto& buffer) -> const detail::Memory& { return buffer.memory(); }, buffer_);
}

detail::Memory& RealBuffer::memory() {
  return std::visit([](auto& buffer) -> detail::Memory& { return buffer.memory(); }, buffer_);
}

Buffer<float>& RealBuffer::as_float() { return typed<float>(buffer_, *this); }
const Buffer<float>& RealBuffer::as_float() const { return typed<float>(buffer_, *this); }
Buffer<double>& RealBuffer::as_double() { return typed<double>(buffer_, *this); }
const Buffer<double>& RealBuffer::as_double() const { return typed<double>(buffer_, *this); }

}  // namespace simuli
