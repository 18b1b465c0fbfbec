#pragma once
// Bundles of the named options: speed against accuracy (README, bench/trade/trade.hpp).
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/render/options/options.hpp"

namespace simuli {

enum class Quality { kDraft, kBalanced, kExact, kReference };

/// "draft", "balanced", "exact", "reference": in the order of the values.
[[nodiscard]] const std::vector<std::string>& quality_names();
/// Nothing when there is none of that name.
[[nodiscard]] std::optional<Quality> find_quality(std::string_view name);

/// What a bundle sets; kBalanced is RenderOptions{}, the others differ from it.
[[nodiscard]] RenderOptions options_of(Quality quality);

/// The same for trainings: without what has no gradients, and in float; order = window for per_ray.
[[nodiscard]] RenderOptions training_options_of(Quality quality);

/// Whether the backward pass knows these options: direction of colours, bands and level of detail as by default.
[[nodiscard]] bool has_gradients(const RenderOptions& options);

}  // namespace simuli
