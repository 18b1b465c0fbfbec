#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <string_view>

namespace simuli::cli {

/// Whether other machines cannot reach a listening address.
[[nodiscard]] inline bool is_loopback(std::string_view host) {
  constexpr std::array<std::string_view, 3> kLoopback{"127.0.0.1", "localhost", "::1"};
  return std::find(kLoopback.begin(), kLoopback.end(), host) != kLoopback.end();
}

/// Returns the host of "host:port" or "[host]:port"; empty for other text.
[[nodiscard]] inline std::string host_of_header(const std::string& header) {
  const bool is_v6 = !header.empty() && header.front() == '[';
  const std::size_t end = is_v6 ? header.find(']') : std::min(header.find(':'), header.size());
  if (end == std::string::npos) return {};
  const std::string_view port = std::string_view(header).substr(is_v6 ? end + 1 : end);
  const bool is_port = port.empty() || (port.front() == ':' &&
                                        port.find_first_not_of("0123456789", 1) == std::string_view::npos);
  return is_port ? header.substr(is_v6 ? 1 : 0, is_v6 ? end - 1 : end) : std::string();
}

}  // namespace simuli::cli
