#include "host/apps/serve/session/metrics.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace simuli::serve {
namespace {

constexpr std::array<const char*, 5> kStages{
    "worker_wait", "scene_read", "device_wait", "rendering", "encoding"};

std::string head(const std::string& name, const char* type, const std::string& help) {
  return fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
}

std::string counter(const std::string& name, const std::string& help, std::uint64_t value) {
  return head(name, "counter", help) + fmt::format("{} {}\n", name, value);
}

}  // namespace

void Histogram::add(double seconds) {
  const auto bound = std::lower_bound(kBounds_s.begin(), kBounds_s.end(), seconds);
  ++counts_[static_cast<std::size_t>(bound - kBounds_s.begin())];
  sum_s_ += seconds;
}

std::string Histogram::text(const std::string& name, const std::string& labels) const {
  std::string out;
  std::uint64_t up_to = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    up_to += counts_[i];
    const std::string bound = i < kBounds_s.size() ? fmt::format("{}", kBounds_s[i]) : "+Inf";
    out += fmt::format("{}_bucket{{{},le=\"{}\"}} {}\n", name, labels, bound, up_to);
  }
  return out + fmt::format("{}_sum{{{}}} {}\n{}_count{{{}}} {}\n", name, labels, sum_s_, name, labels, up_to);
}

void Metrics::count_call(const std::string& call,
                         const std::string& status,
                         double seconds,
                         std::uint64_t reply_bytes) {
  const std::lock_guard lock(mutex_);
  OfCall& of_call = calls_[call];
  ++of_call.by_status[status];
  of_call.seconds.add(seconds);
  of_call.reply_bytes += reply_bytes;
}

void Metrics::add_time(RequestStage stage, double seconds) {
  const std::lock_guard lock(mutex_);
  stages_[static_cast<std::size_t>(stage)].add(seconds);
}

void Metrics::count_frame(bool is_rendered) {
  const std::lock_guard lock(mutex_);
  ++(is_rendered ? rendered_ : failed_);
}

void Metrics::count_hit() {
  const std::lock_guard lock(mutex_);
  ++hits_;
}
void Metrics::count_load() {
  const std::lock_guard lock(mutex_);
  ++loads_;
}
void Metrics::count_eviction() {
  const std::lock_guard lock(mutex_);
  ++evictions_;
}

std::string Metrics::text(std::span<const Gauge> gauges) const {
  const std::lock_guard lock(mutex_);
  std::string out = head("simuli_requests_total", "counter", "Requests answered, by call and status.");
  for (const auto& [call, of_call] : calls_) {
    for (const auto& [status, count] : of_call.by_status) {
      out += fmt::format("simuli_requests_total{{call=\"{}\",status=\"{}\"}} {}\n", call, status, count);
    }
  }
  out += head("simuli_reply_bytes_total", "counter", "Bytes of the messages that were replied, by call.");
  for (const auto& [call, of_call] : calls_) {
    out += fmt::format("simuli_reply_bytes_total{{call=\"{}\"}} {}\n", call, of_call.reply_bytes);
  }
  out += head("simuli_request_seconds", "histogram", "From a request's arrival to its reply, by call.");
  for (const auto& [call, of_call] : calls_) {
    out += of_call.seconds.text("simuli_request_seconds", fmt::format("call=\"{}\"", call));
  }
  out += head("simuli_stage_seconds", "histogram", "Where requests' time goes, by stage.");
  for (std::size_t i = 0; i < kStages.size(); ++i) {
    out += stages_[i].text("simuli_stage_seconds", fmt::format("stage=\"{}\"", kStages[i]));
  }
  out += head("simuli_frames_total", "counter", "Pictures and sweeps that were rendered, and that failed.");
  out += fmt::format("simuli_frames_total{{result=\"rendered\"}} {}\n", rendered_);
  out += fmt::format("simuli_frames_total{{result=\"failed\"}} {}\n", failed_);
  out += counter("simuli_scene_hits_total", "Requests whose scene was in memory.", hits_);
  out += counter("simuli_scene_loads_total", "Scenes that were read.", loads_);
  out += counter("simuli_scene_evictions_total", "Scenes that made room for others.", evictions_);
  for (const Gauge& gauge : gauges) {
    out += head(gauge.name, "gauge", gauge.help) + fmt::format("{} {}\n", gauge.name, gauge.value);
  }
  return out;
}

}  // namespace simuli::serve
