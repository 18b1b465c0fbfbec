#pragma once
#include <algorithm>
#include <array>
#include <string_view>

namespace simuli::cli {

/// Whether an address to listen on is one that no other machine reaches.
[[nodiscard]] inline bool is_loopback(std::string_view host) {
  constexpr std::array<std::string_view, 3> kLoopback{"127.0.0.1", "localhost", "::1"};
  return std::find(kLoopback.begin(), kLoopback.end(), host) != kLoopback.end();
}

}  // namespace simuli::cli
