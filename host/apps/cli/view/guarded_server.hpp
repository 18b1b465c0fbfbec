#pragma once
// The library's server behind limits of its own: it waits for each client as long as that takes, one thread
// each, so that a few slow ones keep out everybody else.
#include <Eigen/Core>  // before httplib.h, with which <resolv.h> makes a macro of a name of Eigen's
#include <httplib.h>
#include <memory>

namespace simuli::cli {

/// A request has to come whole within seconds, its header within 64 KiB, and replies have to be taken; where
/// connections wait for a thread, who is slow or idle has a fraction of a second. Beyond a number of waiting
/// connections new ones are closed at once.
class GuardedServer : public httplib::Server {
 public:
  GuardedServer();
  /// More than the library asks for: connections that come at the same time are kept instead of tried again
  /// after a second. To be called when bound.
  void widen_backlog();

 private:
  struct Crowd;
  class Queue;
  class Connection;
  bool process_and_close_socket(socket_t socket) override;

  std::shared_ptr<Crowd> crowd_;
};

}  // namespace simuli::cli
