#pragma once
// The viewer's web server.
#include <memory>
#include <string>

#include "host/apps/cli/view/view_answers.hpp"

namespace simuli::cli {

struct ServerOptions {
  std::string host = "127.0.0.1";  // other than a loopback address: with a token alone
  int port = 8080;                 // 0: any free one
  std::string token;               // asked for with every request but those for the page itself
};

/// Serves the page and the answers from threads of its own, until it is destroyed.
class ViewServer {
 public:
  /// Error{kUsage} for another host without a token, and when the address can't be bound.
  ViewServer(ViewAnswers& answers, const ServerOptions& options);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// Where the page is, with the token.
  [[nodiscard]] std::string url() const;
  /// Returns when the server has stopped.
  void wait();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace simuli::cli
