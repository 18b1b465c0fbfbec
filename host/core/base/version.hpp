#pragma once

namespace simuli {

/// "0.1.0"
[[nodiscard]] const char* version();

}  // namespace simuli
