#pragma once
// The library's server behind limits of its own: it waits for each client as long as that takes, one thread
// each, so that a few slow ones keep out everybody else.
#include <Eigen/Core>  // before httplib.h, with which <resolv.h> makes a macro of a name of Eigen's
#include <httplib.h>
#include <memory>
#include <string>
#include <thread>

namespace simuli::cli {

/// A request has to come whole within seconds, its header within 64 KiB, and replies have to be taken; where
/// connections wait for a thread, who is slow or idle has a fraction of a second. Beyond a number of waiting
/// connections new ones are closed at once.
class GuardedServer : public httplib::Server {
 public:
  GuardedServer();
  ~GuardedServer() override;
  /// Answers from threads of its own until it is destroyed; `port` 0: any free one. Error{kUsage} naming `option`
  /// where the address can't be bound.
  void start(const std::string& host, int port, const char* option);
  /// "http://127.0.0.1:8080".
  [[nodiscard]] std::string url() const;
  /// Returns when it has stopped.
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
