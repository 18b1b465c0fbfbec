#include "host/device/runtime/buffer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fmt/format.h>

#include "host/core/base/interruption.hpp"
#include "host/device/runtime/cl_error.hpp"
#include "host/device/runtime/device_state.hpp"
#include "host/device/runtime/pending.hpp"

namespace simuli::detail {
namespace {

// Largest pattern of clEnqueueFillBuffer in bytes; pattern sizes are powers of two.
constexpr std::size_t kMaxFillPatternBytes = 128;
// Largest host copy in bytes for elements of a size that clEnqueueFillBuffer does not support.
constexpr std::size_t kFillChunkBytes = std::size_t{1} << 20U;
// Bytes written between two checks for an interruption.
constexpr std::size_t kHeardChunkBytes = std::size_t{1} << 25U;

void need_success(cl_int code, const char* call) {
  if (code != CL_SUCCESS) throw cl::Error(code, call);
}

void copy(const Device& device, cl_mem source, cl_mem target, std::size_t bytes) {
  need_success(clEnqueueCopyBuffer(device.state().queue(), source, target, 0, 0, bytes, 0, nullptr, nullptr),
               "clEnqueueCopyBuffer");
}

}  // namespace

MemoryLease::MemoryLease(const Device& device, const std::string& name, std::size_t bytes)
    : device_(device), by_name_(&device.state().memory_by_name[name]), bytes_(bytes) {
  for (MemoryUse* use : {&device.state().memory, by_name_}) {
    use->now += bytes;
    use->peak = std::max(use->peak, use->now);
  }
}

MemoryLease::~MemoryLease() {
  if (!device_) return;
  device_->state().memory.now -= bytes_;
  by_name_->now -= bytes_;
}

void MemoryLease::exchange(MemoryLease& other) noexcept {
  for (const auto& [to, from] : {std::pair(this, &other), std::pair(&other, this)}) {
    if (to->by_name_ == nullptr) continue;
    to->by_name_->now += from->bytes_ - to->bytes_;
    to->by_name_->peak = std::max(to->by_name_->peak, to->by_name_->now);
  }
  std::swap(bytes_, other.bytes_);
}

void Memory::Release::operator()(_cl_mem* handle) const noexcept {
  if (!Device::is_forked()) clReleaseMemObject(handle);
}

Memory::Memory(const Device& device, std::string name, std::size_t element_bytes)
    : device_(device), name_(std::move(name)), element_bytes_(element_bytes) {
  allocate(0);
}

void Memory::allocate(std::size_t count) {
  const std::uint64_t allowed = device_.info().max_alloc_bytes;
  if (!(count <= allowed / element_bytes_)) {
    throw Error(ErrorKind::kDevice,
                fmt::format("buffer {}: {} elements of {} bytes are wanted, {} allows {} bytes per buffer",
                            name_,
                            count,
                            element_bytes_,
                            device_.info().label(),
                            allowed));
  }
  const std::size_t bytes = std::max<std::size_t>(count, 1) * element_bytes_;
  cl_call(
      ErrorKind::kDevice,
      [&] { return fmt::format("allocating buffer {} of {} bytes", name_, bytes); },
      [&] {
        cl_int code = CL_SUCCESS;
        handle_.reset(clCreateBuffer(device_.state().context(), CL_MEM_READ_WRITE, bytes, nullptr, &code));
        need_success(code, "clCreateBuffer");
      });
  capacity_ = count;
  lease_ = MemoryLease(device_, name_, bytes);
}

void Memory::reserve(std::size_t count) {
  if (count > capacity_) {
    // Releases the old allocation first, so that growing never needs both at once.
    count_ = 0;
    capacity_ = 0;
    handle_.reset();
    lease_ = {};
    try {
      allocate(count);
    } catch (const Error&) {
      allocate(0);  // still a valid, empty buffer
      throw;
    }
  }
  count_ = count;
}

void Memory::extend(std::size_t count) {
  if (count <= capacity_) {
    count_ = count;
    return;
  }
  Memory larger(device_, name_, element_bytes_);
  larger.reserve(count);
  const std::size_t bytes = count_ * element_bytes_;
  if (bytes > 0) {
    cl_call(
        ErrorKind::kDevice,
        [&] { return fmt::format("copying {} bytes of buffer {}", bytes, name_); },
        [&] { copy(device_, handle(), larger.handle(), bytes); });
  }
  *this = std::move(larger);
}

void Memory::need_range(const char* what, std::size_t first, std::size_t count) const {
  if (first <= count_ && count <= count_ - first) return;
  throw Error(
      ErrorKind::kInternal,
      fmt::format(
          "buffer {}: {} of {} elements from {} on, the buffer has {}", name_, what, count, first, count_));
}

void Memory::write(std::size_t first, const void* source, std::size_t count) {
  need_range("upload", first, count);
  if (count == 0) return;
  if (Interruption::is_on()) Event(device_).wait();
  const std::size_t most = std::max<std::size_t>(kHeardChunkBytes / element_bytes_, 1);
  if (Interruption::is_on() && count > most) {
    write(first, source, most);
    return write(first + most, static_cast<const std::byte*>(source) + most * element_bytes_, count - most);
  }
  const std::size_t bytes = count * element_bytes_;
  cl_call(
      ErrorKind::kDevice,
      [&] { return fmt::format("writing {} bytes of buffer {}", bytes, name_); },
      [&] {
        need_success(clEnqueueWriteBuffer(device_.state().queue(),
                                          handle(),
                                          CL_TRUE,
                                          first * element_bytes_,
                                          bytes,
                                          source,
                                          0,
                                          nullptr,
                                          nullptr),
                     "clEnqueueWriteBuffer");
      });
}

void Memory::queue_rows(
    std::size_t first, std::size_t pitch, std::size_t columns, const void* source, std::size_t rows) {
  if (rows == 0 || columns == 0) return;
  if (columns > pitch) {
    throw Error(ErrorKind::kInternal,
                fmt::format("buffer {}: rows of {} elements, {} apart", name_, columns, pitch));
  }
  need_range("upload", first, (rows - 1) * pitch + columns);
  const std::array<std::size_t, 3> to{first * element_bytes_, 0, 0}, from{0, 0, 0},
      region{columns * element_bytes_, rows, 1};
  cl_call(
      ErrorKind::kDevice,
      [&] { return fmt::format("writing {} rows of {} bytes of buffer {}", rows, region[0], name_); },
      [&] {
        need_success(clEnqueueWriteBufferRect(device_.state().queue(),
                                              handle(),
                                              CL_FALSE,
                                              to.data(),
                                              from.data(),
                                              region.data(),
                                              pitch * element_bytes_,
                                              0,
                                              region[0],
                                              0,
                                              source,
                                              0,
                                              nullptr,
                                              nullptr),
                     "clEnqueueWriteBufferRect");
      });
}

void Memory::read(std::size_t first, void* target, std::size_t count) const {
  need_range("download", first, count);
  if (count == 0) return;
  if (Interruption::is_on()) Event(device_).wait();
  const std::size_t bytes = count * element_bytes_;
  cl_call(
      ErrorKind::kDevice,
      [&] { return fmt::format("reading {} bytes of buffer {}", bytes, name_); },
      [&] {
        need_success(clEnqueueReadBuffer(device_.state().queue(),
                                         handle(),
                                         CL_TRUE,
                                         first * element_bytes_,
                                         bytes,
                                         target,
                                         0,
                                         nullptr,
                                         nullptr),
                     "clEnqueueReadBuffer");
      });
}

void Memory::fill(const void* element) {
  if (count_ == 0) return;
  const std::size_t bytes = count_ * element_bytes_;
  if (std::has_single_bit(element_bytes_) && element_bytes_ <= kMaxFillPatternBytes) {
    cl_call(
        ErrorKind::kDevice,
        [&] { return fmt::format("filling {} bytes of buffer {}", bytes, name_); },
        [&] {
          need_success(
              clEnqueueFillBuffer(
                  device_.state().queue(), handle(), element, element_bytes_, 0, bytes, 0, nullptr, nullptr),
              "clEnqueueFillBuffer");
        });
    return;
  }
  const std::size_t chunk = std::min(count_, std::max<std::size_t>(kFillChunkBytes / element_bytes_, 1));
  std::vector<std::byte> pattern(chunk * element_bytes_);
  for (std::size_t i = 0; i < chunk; ++i) {
    std::memcpy(pattern.data() + i * element_bytes_, element, element_bytes_);
  }
  for (std::size_t first = 0; first < count_; first += chunk) {
    write(first, pattern.data(), std::min(chunk, count_ - first));
  }
}

void Memory::copy_from(const Memory& source) {
  if (source.count_ != count_ || source.element_bytes_ != element_bytes_) {
    throw Error(ErrorKind::kInternal,
                fmt::format("buffer {}: copy from buffer {} of {} elements, this one has {}",
                            name_,
                            source.name_,
                            source.count_,
                            count_));
  }
  if (count_ == 0 || this == &source) return;
  const std::size_t bytes = count_ * element_bytes_;
  cl_call(
      ErrorKind::kDevice,
      [&] { return fmt::format("copying {} bytes of buffer {} to {}", bytes, source.name_, name_); },
      [&] { copy(device_, source.handle(), handle(), bytes); });
}

void Memory::exchange(Memory& other) noexcept {
  std::swap(count_, other.count_);
  std::swap(capacity_, other.capacity_);
  handle_.swap(other.handle_);
  lease_.exchange(other.lease_);
}

}  // namespace simuli::detail
