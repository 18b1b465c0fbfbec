#pragma once
#include <string>
#include <vector>

#include "optim/eval/eval_options.hpp"

namespace simuli {

/// The options of `simuli eval --quality QUALITY --set SETTING...`: quality "" is balanced; settings are
/// "key=value" each, "image_scale", "held_out_every", "held_out_middle" and "held_out_last" among the keys.
/// Error{kUsage} naming key, found and allowed.
[[nodiscard]] EvalOptions eval_options(const std::string& quality, const std::vector<std::string>& settings);

}  // namespace simuli
