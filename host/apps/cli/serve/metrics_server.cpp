#include "host/apps/cli/serve/metrics_server.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <thread>
#include <utility>

#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/view/guarded_server.hpp"
#include "host/apps/cli/view/loopback.hpp"
#include "host/core/base/error.hpp"

namespace simuli::cli {

struct MetricsServer::Impl {
  GuardedServer server;
  std::thread thread;
  std::string host;
  int port = 0;
};

MetricsServer::MetricsServer(const std::string& host, int port, std::function<std::string()> text)
    : impl_(std::make_unique<Impl>()) {
  impl_->host = host;
  GuardedServer& server = impl_->server;
  // The library's own choice (SO_REUSEPORT) would let a second server listen on a port that is taken.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  server.set_payload_max_length(0);
  server.set_default_headers({{"Cache-Control", "no-store"}, {"X-Content-Type-Options", "nosniff"}});
  server.set_pre_routing_handler(
      [loopback = is_loopback(host)](const httplib::Request& request, httplib::Response& response) {
        // A page of another site whose name has been pointed here must not read along.
        if (!loopback || is_loopback(host_of_header(request.get_header_value("Host")))) {
          return httplib::Server::HandlerResponse::Unhandled;
        }
        response.status = 403;
        response.set_content("not a name of this machine", "text/plain");
        return httplib::Server::HandlerResponse::Handled;
      });
  server.Get("/metrics", [text = std::move(text)](const httplib::Request&, httplib::Response& response) {
    response.set_content(text(), "text/plain; version=0.0.4; charset=utf-8");
  });
  const bool is_bound = port == 0 ? (impl_->port = server.bind_to_any_port(host)) > 0
                                  : server.bind_to_port(host, impl_->port = port);
  if (!is_bound) {
    throw_usage_error("--metrics-port",
                      fmt::format("{} on {}, which can't be bound", port, host),
                      "a free one, or 0 for any");
  }
  server.widen_backlog();
  impl_->thread = std::thread([this] { impl_->server.listen_after_bind(); });
}

MetricsServer::~MetricsServer() {
  impl_->server.stop();
  if (impl_->thread.joinable()) impl_->thread.join();
}

std::string MetricsServer::url() const {
  const bool is_v6 = impl_->host.find(':') != std::string::npos;
  return fmt::format("http://{}:{}/metrics", is_v6 ? "[" + impl_->host + "]" : impl_->host, impl_->port);
}

}  // namespace simuli::cli
