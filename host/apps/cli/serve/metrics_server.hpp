#pragma once
// HTTP server of metrics for Prometheus.
#include <functional>
#include <memory>
#include <string>

namespace simuli::cli {

/// Answers GET /metrics in its own threads until destruction.
class MetricsServer {
 public:
  /// `port` 0 selects a free port. `text` is called from any thread and must outlive this object. Throws
  /// Error{kUsage} for an address that cannot be bound, and in a build without the viewer, which contains the
  /// HTTP server.
  MetricsServer(const std::string& host, int port, std::function<std::string()> text);
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;
  ~MetricsServer();

  /// Returns "http://127.0.0.1:9464/metrics".
  [[nodiscard]] std::string url() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace simuli::cli
