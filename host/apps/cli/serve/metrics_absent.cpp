// Metrics server of a build without the viewer's HTTP server.
#include "host/apps/cli/serve/metrics_server.hpp"
#include "host/core/base/error.hpp"

namespace simuli::cli {

struct MetricsServer::Impl {};

MetricsServer::MetricsServer(const std::string& /*host*/,
                             int /*port*/,
                             std::function<std::string()> /*text*/) {
  throw Error(ErrorKind::kUsage,
              "--metrics-port: found a build without the viewer, allowed one with -D SIMULI_VIEWER=ON");
}
MetricsServer::~MetricsServer() = default;
std::string MetricsServer::url() const { return {}; }

}  // namespace simuli::cli
