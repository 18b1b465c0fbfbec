#pragma once
// "--set KEY=VALUE": keys, what they set, and how values are read.
#include <cstddef>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "host/render/options/options.hpp"

namespace simuli::cli {

/// One of several named values.
struct Choice {
  std::vector<std::string> names;  // of the values 0, 1, ...
  std::function<std::size_t()> get;
  std::function<void(std::size_t)> set;
};

struct Setting {
  std::string key;
  std::variant<double*, int*, std::size_t*, bool*, Choice> target;
};

/// Applies "key=value" lines. Error{kUsage} for a key that is not there (listing all keys), for one that
/// stands twice, and for a value that is not one of the key's kind.
void apply_settings(const std::vector<std::string>& settings, const std::vector<Setting>& all);
/// All keys with their values, "key=value" each, in their order.
[[nodiscard]] std::vector<std::string> list_settings(const std::vector<Setting>& all);

/// The keys "render.*": how frames are rendered (host/render/options/options.hpp).
[[nodiscard]] std::vector<Setting> render_settings(RenderOptions& options);

}  // namespace simuli::cli
