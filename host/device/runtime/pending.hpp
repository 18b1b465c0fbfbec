#pragma once
// What the device has been asked for and need not have done yet.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/device/runtime/real_buffer.hpp"

struct _cl_event;  // what a cl_event points to (host/apps/api/opencl.h)

namespace simuli {

/// When everything that was queued on a device so far is done. A handle.
class Event {
 public:
  explicit Event(const Device& device);

  /// Whether it is done; does not wait. Error{kDevice} when it failed.
  [[nodiscard]] bool is_done() const;
  /// Until it is done, or Interruption::ask() throws. Error{kDevice} when it failed.
  void wait() const;
  /// Borrowed: valid as long as any copy.
  [[nodiscard]] _cl_event* handle() const;

 private:
  friend class Download;
  friend class ByteDownload;
  struct State;
  explicit Event(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

/// The content of a buffer on its way to the host, as it is when everything that was queued before is done;
/// what is queued later may write to the buffer. Move-only.
class Download {
 public:
  /// Starts it; does not wait.
  explicit Download(const RealBuffer& buffer);
  Download(Download&&) noexcept;
  Download& operator=(Download&&) noexcept;
  Download(const Download&) = delete;
  Download& operator=(const Download&) = delete;
  ~Download();

  [[nodiscard]] bool is_done() const;
  /// Waits, and gives the values, which can be taken once. Errors as Event::wait().
  [[nodiscard]] std::vector<float> take();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The same of bytes. Move-only; its destructor waits.
class ByteDownload {
 public:
  /// Starts it; does not wait.
  explicit ByteDownload(const Buffer<std::uint8_t>& buffer);
  ByteDownload(ByteDownload&&) noexcept;
  ByteDownload& operator=(ByteDownload&&) noexcept;
  ByteDownload(const ByteDownload&) = delete;
  ByteDownload& operator=(const ByteDownload&) = delete;
  ~ByteDownload();

  /// Waits, and gives the bytes, which can be taken once. Errors as Event::wait().
  [[nodiscard]] std::string take();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli
