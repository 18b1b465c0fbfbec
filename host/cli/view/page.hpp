#pragma once
#include <span>

#include "host/runtime/text/source.hpp"

namespace simuli::cli {

/// The files of host/cli/page/, as embedded at build time.
[[nodiscard]] std::span<const EmbeddedFile> page_files();

}  // namespace simuli::cli
