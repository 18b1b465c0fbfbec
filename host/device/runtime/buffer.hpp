#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/device/runtime/device.hpp"

struct _cl_mem;  // the object behind a cl_mem (host/device/runtime/opencl.hpp)

namespace simuli {
namespace detail {

/// Adds bytes to a device's memory use, in total and by buffer name, during its lifetime.
class MemoryLease {
 public:
  MemoryLease() = default;
  MemoryLease(const Device& device, const std::string& name, std::size_t bytes);
  MemoryLease(MemoryLease&& other) noexcept { swap(other); }
  MemoryLease& operator=(MemoryLease&& other) noexcept {
    MemoryLease(std::move(other)).swap(*this);
    return *this;
  }
  MemoryLease(const MemoryLease&) = delete;
  MemoryLease& operator=(const MemoryLease&) = delete;
  ~MemoryLease();
  /// Swaps the counted bytes of two buffers whose contents were swapped; each keeps its name.
  void exchange(MemoryLease& other) noexcept;

 private:
  void swap(MemoryLease& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(by_name_, other.by_name_);
    std::swap(bytes_, other.bytes_);
  }
  std::optional<Device> device_;
  MemoryUse* by_name_ = nullptr;  // owned by the device, which outlives this
  std::size_t bytes_ = 0;
};

/// The untyped part of Buffer<T>: `count` elements of `element_bytes` in one cl_mem. Never empty on
/// the device: a count of 0 has a minimal allocation, so that it can be a kernel argument.
class Memory {
 public:
  Memory(const Device& device, std::string name, std::size_t element_bytes);

  void reserve(std::size_t count);
  void extend(std::size_t count);
  void write(std::size_t first, const void* source, std::size_t count);
  void queue_rows(
      std::size_t first, std::size_t pitch, std::size_t columns, const void* source, std::size_t rows);
  void read(std::size_t first, void* target, std::size_t count) const;
  void fill(const void* element);
  void copy_from(const Memory& source);
  /// Swaps content, count and capacity; each keeps its name.
  void exchange(Memory& other) noexcept;

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Device& device() const { return device_; }
  [[nodiscard]] _cl_mem* handle() const { return handle_.get(); }

 private:
  struct Release {
    void operator()(_cl_mem* handle) const noexcept;
  };
  void allocate(std::size_t count);
  void need_range(const char* what, std::size_t first, std::size_t count) const;

  Device device_;
  std::string name_;
  std::size_t element_bytes_;
  std::size_t count_ = 0;
  std::size_t capacity_ = 0;
  std::unique_ptr<_cl_mem, Release> handle_;
  MemoryLease lease_;
};

}  // namespace detail

/// An array of T on one device. Move-only owner; a moved-from buffer may only be assigned or destroyed.
/// `name` appears in errors. Transfers block until done. Wrong ranges are Error{kInternal}; sizes
/// above the device's limit, a failed allocation or transfer Error{kDevice} naming buffer and bytes.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T> && !std::is_const_v<T>);

 public:
  /// Holds `count` elements of undefined content; `count` may be 0.
  Buffer(const Device& device, std::string name, std::size_t count = 0)
      : memory_(device, std::move(name), sizeof(T)) {
    memory_.reserve(count);
  }
  /// Holds a copy of `values`.
  Buffer(const Device& device, std::string name, std::span<const T> values)
      : Buffer(device, std::move(name), values.size()) {
    upload(values);
  }
  Buffer(const Device& device, std::string name, const std::vector<T>& values)
      : Buffer(device, std::move(name), std::span<const T>(values)) {}
  Buffer(Buffer&&) noexcept = default;
  Buffer& operator=(Buffer&&) noexcept = default;
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() = default;

  /// Sets count() to `count`. Allocates only when that exceeds capacity(), which loses the content; never
  /// shrinks.
  void reserve(std::size_t count) { memory_.reserve(count); }
  /// Sets count() to `count` and keeps the content; new elements are undefined.
  void extend(std::size_t count) { memory_.extend(count); }
  /// reserve(values.size()) and upload(values).
  void assign(std::span<const T> values) {
    reserve(values.size());
    upload(values);
  }

  /// Replaces all elements; values.size() must be count().
  void upload(std::span<const T> values) {
    need_all(values.size());
    memory_.write(0, values.data(), values.size());
  }
  /// Replaces the elements [first, first + values.size()).
  void upload_at(std::size_t first, std::span<const T> values) {
    memory_.write(first, values.data(), values.size());
  }
  /// Writes values[rows][columns]: row r replaces `columns` elements from first + r * pitch on. Does not wait:
  /// the caller keeps `values` unchanged until the device has read them (Event).
  void queue_rows(std::size_t first, std::size_t pitch, std::size_t columns, std::span<const T> values) {
    memory_.queue_rows(first, pitch, columns, values.data(), columns == 0 ? 0 : values.size() / columns);
  }
  [[nodiscard]] std::vector<T> download() const {
    std::vector<T> values(count());
    memory_.read(0, values.data(), values.size());
    return values;
  }
  /// Copies all elements to `target`, which has exactly count() elements.
  void download(std::span<T> target) const {
    need_all(target.size());
    memory_.read(0, target.data(), target.size());
  }
  /// Copies the elements [first, first + target.size()) to `target`.
  void download_at(std::size_t first, std::span<T> target) const {
    memory_.read(first, target.data(), target.size());
  }
  /// Returns one element, such as a counter. Waits for the queue.
  [[nodiscard]] T read_back(std::size_t index = 0) const {
    T value;
    memory_.read(index, &value, 1);
    return value;
  }

  /// Sets every element of [0, count()). Does not wait.
  void fill(const T& value) { memory_.fill(&value); }
  /// Copies all of `source`, which has the same count(), on the device. Does not wait.
  void copy_from(const Buffer& source) { memory_.copy_from(source.memory_); }
  /// Swaps the content with that of `other` without a copy; each keeps its name.
  void exchange(Buffer& other) noexcept { memory_.exchange(other.memory_); }

  [[nodiscard]] std::size_t count() const { return memory_.count(); }
  [[nodiscard]] std::size_t capacity() const { return memory_.capacity(); }
  [[nodiscard]] std::size_t bytes() const { return memory_.capacity() * sizeof(T); }
  [[nodiscard]] const std::string& name() const { return memory_.name(); }
  [[nodiscard]] const Device& device() const { return memory_.device(); }
  [[nodiscard]] const detail::Memory& memory() const { return memory_; }
  [[nodiscard]] detail::Memory& memory() { return memory_; }

 private:
  void need_all(std::size_t count) const {
    if (count != memory_.count()) {
      throw Error(ErrorKind::kInternal,
                  "buffer " + name() + ": the host span has " + std::to_string(count) +
                      " elements, the buffer " + std::to_string(memory_.count()));
    }
  }

  detail::Memory memory_;
};

}  // namespace simuli
