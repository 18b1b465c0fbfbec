#pragma once
// HTTP server with limits. The library waits for each client without a limit in a thread of its own, so that a
// few slow clients would block all others.
#include <Eigen/Core>  // before httplib.h, with which <resolv.h> makes a macro of a name of Eigen's
#include <httplib.h>
#include <memory>
#include <string>
#include <thread>

namespace simuli::cli {

/// Requests must arrive within seconds, with headers up to 64 KiB, and replies must be read; while connections
/// wait for a thread, slow or idle clients get a fraction of a second. Connections beyond a maximum are closed
/// at once.
class GuardedServer : public httplib::Server {
 public:
  GuardedServer();
  ~GuardedServer() override;
  /// Answers in its own threads until destruction; `port` 0 selects a free one. Throws Error{kUsage} naming
  /// `option` for an address that cannot be bound.
  void start(const std::string& host, int port, const char* option);
  /// Returns "http://127.0.0.1:8080".
  [[nodiscard]] std::string url() const;
  /// Returns after the server has stopped.
  void wait();

 private:
  struct Crowd;
  class Queue;
  class Connection;
  bool process_and_close_socket(socket_t socket) override;

  std::shared_ptr<Crowd> crowd_;
  std::thread thread_;
  std::string host_;
  int port_ = 0;
};

}  // namespace simuli::cli
