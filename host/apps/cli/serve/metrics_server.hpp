#pragma once
// Numbers for Prometheus, by HTTP.
#include <functional>
#include <memory>
#include <string>

namespace simuli::cli {

/// Answers GET /metrics from threads of its own until it is destroyed.
class MetricsServer {
 public:
  /// `port` 0: any free one. `text` is asked from any thread, and outlives this. Error{kUsage} for an address
  /// that can't be bound, and in a build without the viewer, whose HTTP server it is.
  MetricsServer(const std::string& host, int port, std::function<std::string()> text);
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;
  ~MetricsServer();

  /// "http://127.0.0.1:9464/metrics".
  [[nodiscard]] std::string url() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace simuli::cli
