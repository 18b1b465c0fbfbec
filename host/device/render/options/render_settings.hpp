#pragma once
// Options from text, for other languages and settings files.
#include <string>
#include <vector>

#include "host/device/render/options/quality.hpp"

namespace simuli {

/// Returns the bundle of that name; "" is balanced. Throws Error{kUsage} with the known names.
[[nodiscard]] Quality quality_of_name(const std::string& name);

/// Returns a bundle changed by settings "render.KEY=VALUE". Throws Error{kUsage} with key, found and allowed
/// value.
[[nodiscard]] RenderOptions render_options(const std::string& quality,
                                           const std::vector<std::string>& settings);

}  // namespace simuli
