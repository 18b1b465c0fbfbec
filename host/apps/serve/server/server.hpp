#pragma once
// The service on the network.
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

#include "host/apps/serve/messages/handlers.hpp"
#include "host/apps/serve/session/unread_replies.hpp"

namespace simuli::serve {

struct ServerOptions {
  std::string host = "127.0.0.1";
  int port = 8080;                // 0 selects a free one
  std::size_t max_workers = 4;    // concurrent requests; others wait
  bool allows_shut_down = false;  // by any client
  ReplyLimits replies;
  /// Age at which a connection is closed; the client reconnects, and calls in progress get the same time again,
  /// which bounds requests that never complete.
  std::chrono::milliseconds connection_age{std::chrono::minutes(5)};
  std::string tls_certificate,
      tls_key;              // PEM files, both or neither; without them traffic is unencrypted
  std::string tls_clients;  // PEM file of authorities that must have signed the clients' certificates
};

/// Answers in its own threads until destruction. Serves the service under both names, and grpc.health.v1.
class Server {
 public:
  /// Largest request, bytes.
  static constexpr int kLargestRequest = 4 << 20;

  /// Throws Error{kUsage} for an address that cannot be bound, Error{kInput} for unreadable TLS files.
  /// `handlers` must outlive this object.
  Server(const Handlers& handlers, const ServerOptions& options);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  /// Equals drain() without patience.
  ~Server();

  [[nodiscard]] int port() const;
  /// Returns "host:port".
  [[nodiscard]] std::string address() const;
  /// Whether a client requested a shutdown, if that is allowed; the owner of the server then calls drain().
  [[nodiscard]] bool is_shut_down_requested() const;
  /// Returns all metrics in Prometheus' text format. Safe to call from any thread.
  [[nodiscard]] std::string metrics() const;
  /// Refuses new calls; returns when the calls in progress are finished and their replies read, or cancelled
  /// after `patience`. Does not wait for idle connections.
  void drain(std::chrono::milliseconds patience);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace simuli::serve
