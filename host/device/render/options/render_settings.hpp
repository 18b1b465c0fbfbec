#pragma once
// Options from text, for callers who have no structs: other languages, files of settings.
#include <string>
#include <vector>

#include "host/device/render/options/quality.hpp"

namespace simuli {

/// The bundle of that name; "": balanced. Error{kUsage} naming those there are.
[[nodiscard]] Quality quality_of_name(const std::string& name);

/// A bundle and what differs from it, "render.KEY=VALUE" each. Error{kUsage} naming key, found and allowed.
[[nodiscard]] RenderOptions render_options(const std::string& quality,
                                           const std::vector<std::string>& settings);

}  // namespace simuli
