#pragma once
// Bundles of the named options: speed against accuracy (README, bench/trade/trade.hpp).
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/device/render/options/options.hpp"

namespace simuli {

enum class Quality { kDraft, kBalanced, kExact, kReference };

/// "draft", "balanced", "exact", "reference": in the order of the values.
[[nodiscard]] const std::vector<std::string>& quality_names();
/// Nothing when there is none of that name.
[[nodiscard]] std::optional<Quality> find_quality(std::string_view name);

/// What a bundle sets; kBalanced is RenderOptions{}, the others differ from it.
[[nodiscard]] RenderOptions options_of(Quality quality);

/// The same for trainings: what these take the default of alone (InTraining) is that; order = window for
/// per_ray.
[[nodiscard]] RenderOptions training_options_of(Quality quality);

/// Error{kUsage} "WHERE: KEY: found, allowed" for the first option whose value has no backward pass.
void need_gradients(RenderOptions options, const std::string& where);

}  // namespace simuli
