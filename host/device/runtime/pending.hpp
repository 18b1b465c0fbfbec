#pragma once
// Work that is queued on a device and may not have finished.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/device/runtime/real_buffer.hpp"

struct _cl_event;  // the object behind a cl_event (host/apps/api/opencl.h)

namespace simuli {

/// Completion of all work that was queued on a device before the event. A handle.
class Event {
 public:
  explicit Event(const Device& device);

  /// Whether the work has finished; does not wait. Throws Error{kDevice} when it failed.
  [[nodiscard]] bool is_done() const;
  /// Waits until the work has finished or Interruption::ask() throws. Throws Error{kDevice} when it failed.
  void wait() const;
  /// Borrowed: valid during the lifetime of any copy.
  [[nodiscard]] _cl_event* handle() const;

 private:
  friend class Download;
  friend class ByteDownload;
  struct State;
  explicit Event(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

/// A queued download of a buffer: its content after all work that was queued before. Work that is queued later
/// may write to the buffer. Move-only.
class Download {
 public:
  /// Queues the download; does not wait.
  explicit Download(const RealBuffer& buffer);
  Download(Download&&) noexcept;
  Download& operator=(Download&&) noexcept;
  Download(const Download&) = delete;
  Download& operator=(const Download&) = delete;
  ~Download();

  [[nodiscard]] bool is_done() const;
  /// Waits and returns the values; may be called once. Errors as Event::wait().
  [[nodiscard]] std::vector<float> take();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The untyped part of PendingRead<T>. Move-only; its destructor waits.
class ByteDownload {
 public:
  /// Queues the download; does not wait.
  explicit ByteDownload(const Buffer<std::uint8_t>& buffer);
  ByteDownload(ByteDownload&&) noexcept;
  ByteDownload& operator=(ByteDownload&&) noexcept;
  ByteDownload(const ByteDownload&) = delete;
  ByteDownload& operator=(const ByteDownload&) = delete;
  ~ByteDownload();

  /// Waits and returns the bytes; may be called once. Errors as Event::wait().
  [[nodiscard]] std::string take();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli
