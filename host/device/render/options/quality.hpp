#pragma once
// Named bundles of options: speed against accuracy (README, bench/trade/trade.hpp).
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/device/render/options/options.hpp"

namespace simuli {

enum class Quality { kDraft, kBalanced, kExact, kReference };

/// Returns "draft", "balanced", "exact", "reference", in the order of the values.
[[nodiscard]] const std::vector<std::string>& quality_names();
/// Returns no value for an unknown name.
[[nodiscard]] std::optional<Quality> find_quality(std::string_view name);

/// Returns the options of a bundle; kBalanced is RenderOptions{}.
[[nodiscard]] RenderOptions options_of(Quality quality);

/// Returns the options of a bundle for trainings: options that trainings fix (InTraining) have their default,
/// and order = window replaces per_ray.
[[nodiscard]] RenderOptions training_options_of(Quality quality);

/// Throws Error{kUsage} "WHERE: KEY: found, allowed" for the first option whose value has no backward pass.
void need_gradients(RenderOptions options, const std::string& where);

// Options from text, for other languages and settings files.

/// Returns the bundle of that name; "" is balanced. Throws Error{kUsage} with the known names.
[[nodiscard]] Quality quality_of_name(const std::string& name);

/// Returns a bundle changed by settings "render.KEY=VALUE". Throws Error{kUsage} with key, found and allowed
/// value.
[[nodiscard]] RenderOptions render_options(const std::string& quality,
                                           const std::vector<std::string>& settings);

}  // namespace simuli
