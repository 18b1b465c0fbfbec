#pragma once
// Web server of the viewer.
#include <memory>
#include <string>

#include "host/apps/cli/view/view_answers.hpp"

namespace simuli::cli {

struct ServerOptions {
  std::string host = "127.0.0.1";  // other addresses than loopback require a token
  int port = 8080;                 // 0 selects a free one
  std::string token;               // required in every request except for the page itself
};

/// Serves the page and the answers in its own threads until destruction.
class ViewServer {
 public:
  /// Throws Error{kUsage} for another host without a token, and for an address that cannot be bound.
  ViewServer(ViewAnswers& answers, const ServerOptions& options);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// Returns the page's address with the token.
  [[nodiscard]] std::string url() const;
  /// Returns after the server has stopped.
  void wait();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace simuli::cli
