#include "host/apps/cli/serve/metrics_server.hpp"

#include <utility>

#include "host/apps/cli/view/guarded_server.hpp"
#include "host/apps/cli/view/loopback.hpp"

namespace simuli::cli {

struct MetricsServer::Impl {
  GuardedServer server;
};

MetricsServer::MetricsServer(const std::string& host, int port, std::function<std::string()> text)
    : impl_(std::make_unique<Impl>()) {
  GuardedServer& server = impl_->server;
  server.set_payload_max_length(0);
  server.set_default_headers({{"Cache-Control", "no-store"}, {"X-Content-Type-Options", "nosniff"}});
  server.set_pre_routing_handler(
      [loopback = is_loopback(host)](const httplib::Request& request, httplib::Response& response) {
        // Prevents DNS rebinding: a page of another site could use a host name with this address.
        if (!loopback || is_loopback(host_of_header(request.get_header_value("Host")))) {
          return httplib::Server::HandlerResponse::Unhandled;
        }
        response.status = 403;
        response.set_content("not the name of this machine", "text/plain");
        return httplib::Server::HandlerResponse::Handled;
      });
  server.Get("/metrics", [text = std::move(text)](const httplib::Request&, httplib::Response& response) {
    response.set_content(text(), "text/plain; version=0.0.4; charset=utf-8");
  });
  server.start(host, port, "--metrics-port");
}

MetricsServer::~MetricsServer() = default;

std::string MetricsServer::url() const { return impl_->server.url() + "/metrics"; }

}  // namespace simuli::cli
