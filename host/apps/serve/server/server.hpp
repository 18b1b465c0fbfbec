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
  int port = 8080;                // 0: any free one
  std::size_t max_workers = 4;    // requests at once; others wait
  bool allows_shut_down = false;  // by any client
  ReplyLimits replies;
  /// Of a connection: then its client makes another one, and has as long again for what it has begun, which
  /// bounds requests that never come whole.
  std::chrono::milliseconds connection_age{std::chrono::minutes(5)};
  std::string tls_certificate,
      tls_key;              // PEM files, both or neither: then everybody on the way can read along
  std::string tls_clients;  // PEM file of authorities: clients must have a certificate of one
};

/// Answers from threads of its own until it is destroyed. Beside the service, under both of its names, stands
/// grpc.health.v1.
class Server {
 public:
  /// Largest request, bytes.
  static constexpr int kLargestRequest = 4 << 20;

  /// Error{kUsage} for an address that can't be bound, Error{kInput} for TLS files that can't be read.
  /// `handlers` outlive it.
  Server(const Handlers& handlers, const ServerOptions& options);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  /// As drain(), without patience.
  ~Server();

  [[nodiscard]] int port() const;
  /// "host:port".
  [[nodiscard]] std::string address() const;
  /// Whether a client has, where that is allowed: who owns the server drains it.
  [[nodiscard]] bool is_shut_down_asked_for() const;
  /// What is counted and what is at work, in Prometheus' text format. Safe to ask from any thread.
  [[nodiscard]] std::string metrics() const;
  /// From here on nothing new is answered; returns when what was begun is done and taken, or cancelled after
  /// `patience`. Clients that are connected and say nothing are not waited for.
  void drain(std::chrono::milliseconds patience);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace simuli::serve
