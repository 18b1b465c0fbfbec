#pragma once
// The keys of "simuli train --set key=value".
#include <string>
#include <vector>

#include "optim/initialize.hpp"
#include "optim/trainer.hpp"

namespace simuli::cli {

/// Applies "key=value" lines. Error{kUsage} for a key that is not there (listing all keys), for one that
/// stands twice, and for a value that is not a number of the key's kind.
void apply_settings(const std::vector<std::string>& settings, InitOptions& init, TrainOptions& train);
/// All keys with their values, "key=value" each, in a fixed order.
[[nodiscard]] std::vector<std::string> list_settings(const InitOptions& init, const TrainOptions& train);

}  // namespace simuli::cli
