#include "host/device/runtime/pending.hpp"

#include <chrono>
#include <fmt/format.h>
#include <thread>
#include <utility>

#include "host/core/base/interruption.hpp"
#include "host/device/runtime/cl_error.hpp"
#include "host/device/runtime/device_state.hpp"

namespace simuli {

struct Event::State {
  explicit State(const Device& on) : device(on) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (Device::is_forked()) event() = nullptr;
  }

  Device device;
  cl::Event event;

  [[nodiscard]] std::string where() const { return "waiting for " + device.info().label(); }
};

Event::Event(const Device& device) : state_(std::make_shared<State>(device)) {
  cl_call(
      ErrorKind::kDevice,
      [&] { return "marking the queue of " + device.info().label(); },
      [&] {
        device.state().queue.enqueueMarkerWithWaitList(nullptr, &state_->event);
        device.state().queue.flush();
      });
}

bool Event::is_done() const {
  return cl_call(
      ErrorKind::kDevice,
      [&] { return state_->where(); },
      [&] {
        const cl_int status = state_->event.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>();
        if (status < 0) throw cl::Error(status, "clGetEventInfo");
        return status == CL_COMPLETE;
      });
}

void Event::wait() const {
  for (; Interruption::is_on() && !is_done(); std::this_thread::sleep_for(std::chrono::microseconds(50))) {
    Interruption::ask();
  }
  cl_call(
      ErrorKind::kDevice, [&] { return state_->where(); }, [&] { state_->event.wait(); });
}

_cl_event* Event::handle() const { return state_->event(); }

namespace {

/// Queues a read of `bytes` bytes of a buffer into `target`.
void start_reading(const detail::Memory& memory, std::size_t bytes, void* target, cl::Event& done) {
  cl_call(
      ErrorKind::kDevice,
      [&] { return fmt::format("reading {} bytes of buffer {}", bytes, memory.name()); },
      [&] {
        const cl::CommandQueue& queue = memory.device().state().queue;
        if (bytes == 0) {
          queue.enqueueMarkerWithWaitList(nullptr, &done);
        } else {
          queue.enqueueReadBuffer(
              cl::Buffer(memory.handle(), true), CL_FALSE, 0, bytes, target, nullptr, &done);
        }
        queue.flush();
      });
}

/// Waits until the driver has stopped writing. Errors are ignored here; Event::wait() reports them.
void wait_quietly(const Event& done) {
  cl_event event = done.handle();
  if (!Device::is_forked()) static_cast<void>(clWaitForEvents(1, &event));
}

}  // namespace

struct Download::State {
  explicit State(std::shared_ptr<Event::State> event) : done(std::move(event)) {}
  Event done;
  std::vector<float> floats;
  std::vector<double> doubles;
};

Download::Download(const RealBuffer& buffer) {
  const detail::Memory& memory = buffer.memory();
  const auto event = std::make_shared<Event::State>(memory.device());
  state_ = std::make_unique<State>(event);
  const bool is_float = buffer.precision() == Precision::kFloat;
  if (is_float) {
    state_->floats.resize(memory.count());
  } else {
    state_->doubles.resize(memory.count());
  }
  void* const target = is_float ? static_cast<void*>(state_->floats.data()) : state_->doubles.data();
  const std::size_t bytes = memory.count() * (is_float ? sizeof(float) : sizeof(double));
  start_reading(memory, bytes, target, event->event);
}

Download::Download(Download&&) noexcept = default;

Download& Download::operator=(Download&& other) noexcept {
  std::swap(state_, other.state_);
  return *this;
}

// The target memory lives until the driver has written it, so that discarded frames need no wait.
Download::~Download() {
  if (!state_ || Device::is_forked() || (state_->floats.empty() && state_->doubles.empty())) return;
  using Written = std::pair<std::vector<float>, std::vector<double>>;
  auto written = std::make_unique<Written>(std::move(state_->floats), std::move(state_->doubles));
  const auto free = [](cl_event, cl_int, void* kept) { delete static_cast<Written*>(kept); };
  if (clSetEventCallback(state_->done.handle(), CL_COMPLETE, free, written.get()) == CL_SUCCESS) {
    static_cast<void>(written.release());
  } else {
    wait_quietly(state_->done);
  }
}

bool Download::is_done() const { return state_->done.is_done(); }

std::vector<float> Download::take() {
  state_->done.wait();
  if (!state_->doubles.empty()) state_->floats.assign(state_->doubles.begin(), state_->doubles.end());
  return std::move(state_->floats);
}

struct ByteDownload::State {
  explicit State(std::shared_ptr<Event::State> event) : done(std::move(event)) {}
  Event done;
  std::string bytes;
};

ByteDownload::ByteDownload(const Buffer<std::uint8_t>& buffer) {
  const detail::Memory& memory = buffer.memory();
  const auto event = std::make_shared<Event::State>(memory.device());
  state_ = std::make_unique<State>(event);
  state_->bytes.resize(memory.count());
  start_reading(memory, memory.count(), state_->bytes.data(), event->event);
}

ByteDownload::ByteDownload(ByteDownload&&) noexcept = default;

ByteDownload& ByteDownload::operator=(ByteDownload&& other) noexcept {
  std::swap(state_, other.state_);
  return *this;
}

ByteDownload::~ByteDownload() {
  if (state_) wait_quietly(state_->done);
}

std::string ByteDownload::take() {
  state_->done.wait();
  return std::move(state_->bytes);
}

}  // namespace simuli
