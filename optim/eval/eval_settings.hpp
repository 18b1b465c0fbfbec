#pragma once
#include <string>
#include <vector>

#include "optim/eval/eval_options.hpp"

namespace simuli {

/// Returns the options of `simuli eval --quality QUALITY --set SETTING...`: an empty quality is balanced; each
/// setting is "key=value", including "image_scale", "held_out_every", "held_out_middle" and "held_out_last".
/// Throws Error{kUsage} with key, found and allowed value.
[[nodiscard]] EvalOptions eval_options(const std::string& quality, const std::vector<std::string>& settings);

}  // namespace simuli
