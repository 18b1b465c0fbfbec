#include "host/apps/cli/view/guarded_server.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <fmt/format.h>
#include <memory>
#include <poll.h>
#include <string>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include "host/apps/cli/base/refuse.hpp"

namespace simuli::cli {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kThreads = 48;
constexpr int kMostWaiting = 512;  // connections without a thread
constexpr int kBacklog = 512;
constexpr milliseconds kRequest{10'000};      // until a request is complete
constexpr milliseconds kReply{30'000};        // until the client has read the reply
constexpr milliseconds kIdle{5'000};          // between two requests
constexpr milliseconds kCrowdedRequest{250};  // request timeout while other connections wait for a thread
constexpr milliseconds kCrowdedReply{2'000};
constexpr milliseconds kCrowdedIdle{20};
constexpr milliseconds kLook{20};  // interval of the check for waiting connections
constexpr std::size_t kMostLineBytes = std::size_t{64} << 10U;  // request line, headers, chunk sizes
constexpr std::size_t kMostBytes = std::size_t{64} << 20U;      // larger bodies are read and refused

/// In the accepting thread: whether connections beyond kMostWaiting are closed.
thread_local bool turns_away = false;

}  // namespace

struct GuardedServer::Crowd {
  std::atomic<int> waiting{0};
};

/// The library's threads, and the number of connections that wait for one.
class GuardedServer::Queue : public httplib::TaskQueue {
 public:
  explicit Queue(std::shared_ptr<Crowd> crowd) : crowd_(std::move(crowd)), threads_(kThreads) {}

  void enqueue(std::function<void()> serve) override {
    if (crowd_->waiting >= kMostWaiting) {
      turns_away = true;
      serve();
      turns_away = false;
      return;
    }
    ++crowd_->waiting;
    threads_.enqueue([crowd = crowd_, serve = std::move(serve)] {
      --crowd->waiting;
      serve();
    });
  }
  void shutdown() override { threads_.shutdown(); }

 private:
  std::shared_ptr<Crowd> crowd_;
  httplib::ThreadPool threads_;
};

/// A client's connection with time limits.
class GuardedServer::Connection : public httplib::Stream {
 public:
  Connection(socket_t socket, const Crowd& crowd, const std::atomic<socket_t>& listener)
      : socket_(socket), crowd_(crowd), listener_(listener) {}

  /// Whether a request begins; its time starts then.
  bool next_request() {
    begin_ = Clock::now();
    if (at_ == end_ && !wait(POLLIN, kIdle, is_first_ ? kCrowdedRequest : kCrowdedIdle)) return false;
    is_first_ = false;
    begin_ = Clock::now();
    writes_ = false;
    bytes_ = line_bytes_ = 0;
    return true;
  }

  [[nodiscard]] bool is_readable() const override {
    return at_ < end_ || wait(POLLIN, kRequest, kCrowdedRequest);
  }
  [[nodiscard]] bool is_writable() const override { return wait(POLLOUT, kReply, kCrowdedReply); }

  ssize_t read(char* to, size_t size) override {
    // The library reads lines byte by byte, but bodies in blocks.
    if (size == 1 && ++line_bytes_ > kMostLineBytes) return -1;
    if (at_ == end_) {
      if (bytes_ > kMostBytes || !is_readable()) return -1;
      const ssize_t got = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
      if (got <= 0) return got;
      at_ = 0;
      end_ = static_cast<std::size_t>(got);
      bytes_ += end_;
    }
    const std::size_t given = std::min(size, end_ - at_);
    std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(at_), given, to);
    at_ += given;
    return static_cast<ssize_t>(given);
  }

  ssize_t write(const char* from, size_t size) override {
    if (!std::exchange(writes_, true)) begin_ = Clock::now();
    for (;;) {
      if (!is_writable()) return -1;
      const ssize_t put = ::send(socket_, from, size, MSG_DONTWAIT | MSG_NOSIGNAL);
      if (put >= 0 || (errno != EAGAIN && errno != EINTR)) return put;
    }
  }

  // Nothing uses the remote address.
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip.clear();
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override { get_remote_ip_and_port(ip, port); }
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  /// Waits until the socket is ready or the time since begin_ has passed; the limit is shorter while others
  /// wait.
  [[nodiscard]] bool wait(short event, milliseconds most, milliseconds crowded) const {
    pollfd ready{socket_, event, 0};
    while (listener_ != INVALID_SOCKET) {
      // Checked first: a client that sends single bytes is always ready.
      if (Clock::now() - begin_ >= (crowd_.waiting > 0 ? crowded : most)) return false;
      if (::poll(&ready, 1, static_cast<int>(kLook.count())) > 0) return true;
    }
    return false;
  }

  socket_t socket_;
  const Crowd& crowd_;
  const std::atomic<socket_t>& listener_;
  Clock::time_point begin_ = Clock::now();
  bool is_first_ = true, writes_ = false;
  std::array<char, 4096> buffer_{};
  std::size_t at_ = 0, end_ = 0;
  std::size_t bytes_ = 0, line_bytes_ = 0;
};

GuardedServer::GuardedServer() : crowd_(std::make_shared<Crowd>()) {
  new_task_queue = [crowd = crowd_] { return new Queue(crowd); };
}

GuardedServer::~GuardedServer() {
  stop();
  wait();
}

void GuardedServer::start(const std::string& host, int port, const char* option) {
  // The library's default (SO_REUSEPORT) would let a second server listen on the same port.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  host_ = host;
  port_ = port == 0 ? bind_to_any_port(host) : port;
  if (port == 0 ? port_ <= 0 : !bind_to_port(host, port)) {
    throw_usage_error(
        option, fmt::format("{} on {}, which can't be bound", port, host), "a free one, or 0 for any");
  }
  // A larger backlog than the library's: simultaneous connections are accepted without a retry after a second.
  static_cast<void>(::listen(svr_sock_, kBacklog));
  thread_ = std::thread([this] { listen_after_bind(); });
}

std::string GuardedServer::url() const {
  const bool is_v6 = host_.find(':') != std::string::npos;
  return fmt::format("http://{}:{}", is_v6 ? "[" + host_ + "]" : host_, port_);
}

void GuardedServer::wait() {
  if (thread_.joinable()) thread_.join();
}

bool GuardedServer::process_and_close_socket(socket_t socket) {
  bool served = false;
  if (!turns_away) {
    Connection connection(socket, *crowd_, svr_sock_);
    for (std::size_t left = keep_alive_max_count_; left > 0 && connection.next_request(); --left) {
      bool closed = false;
      served = process_request(connection, left == 1, closed, nullptr);
      if (!served || closed || svr_sock_ == INVALID_SOCKET) break;
    }
  }
  ::shutdown(socket, SHUT_RDWR);
  ::close(socket);
  return served;
}

}  // namespace simuli::cli
