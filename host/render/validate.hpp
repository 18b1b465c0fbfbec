#pragma once
#include "host/render/options.hpp"

namespace simuli {

/// Error{kUsage} naming the option, what was found and what is allowed. Renderers ask for it; programs ask
/// earlier, before they read what is to be rendered.
void validate(const RenderOptions& options);

}  // namespace simuli
