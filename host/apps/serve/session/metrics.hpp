#pragma once
// Metrics of a server in Prometheus' text format.
#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <string>

namespace simuli::serve {

/// Stages of a request whose durations are measured.
enum class RequestStage { kWorkerWait, kSceneRead, kDeviceWait, kRendering, kEncoding };

/// Histogram of durations in s.
class Histogram {
 public:
  static constexpr std::array<double, 14> kBounds_s{
      0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 60.0};

  void add(double seconds);
  /// Returns the lines `_bucket`, `_sum` and `_count` for one set of labels: "call=\"render_rgb\"".
  [[nodiscard]] std::string text(const std::string& name, const std::string& labels) const;

 private:
  std::array<std::uint64_t, kBounds_s.size() + 1> counts_{};  // the last counter: above all bounds
  double sum_s_ = 0.0;
};

/// A value that is read when metrics are requested.
struct Gauge {
  std::string name, help;
  double value = 0.0;
};

/// Safe to use from any thread.
class Metrics {
 public:
  /// Counts a call by its name in the protocol and its status: "OK", "NOT_FOUND".
  void count_call(const std::string& call,
                  const std::string& status,
                  double seconds,
                  std::uint64_t reply_bytes);
  void add_time(RequestStage stage, double seconds);
  void count_frame(bool is_rendered);
  void count_hit();
  void count_load();
  void count_eviction();

  /// Returns all metrics in a fixed order, followed by the gauges.
  [[nodiscard]] std::string text(std::span<const Gauge> gauges = {}) const;

 private:
  struct OfCall {
    std::map<std::string, std::uint64_t> by_status;
    Histogram seconds;
    std::uint64_t reply_bytes = 0;
  };
  mutable std::mutex mutex_;
  std::map<std::string, OfCall> calls_;
  std::array<Histogram, 5> stages_;  // indexed by RequestStage
  std::uint64_t rendered_ = 0, failed_ = 0;
  std::uint64_t hits_ = 0, loads_ = 0, evictions_ = 0;
};

}  // namespace simuli::serve
