#include "host/device/runtime/pending.hpp"

#include <fmt/format.h>
#include <utility>

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
  cl_call(
      ErrorKind::kDevice, [&] { return state_->where(); }, [&] { state_->event.wait(); });
}

_cl_event* Event::handle() const { return state_->event(); }

namespace {

/// Queues that `bytes` bytes of a buffer are read into `target`.
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

/// The driver writes until then; errors are told to whoever waits for it, and nothing is written any more.
void wait_quietly(const Event& done) {
  try {
    done.wait();
  } catch (const Error&) {
  }
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

Download::~Download() {
  if (state_) wait_quietly(state_->done);
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
