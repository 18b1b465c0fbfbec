#pragma once
#include <span>

#include "host/device/runtime/source.hpp"

namespace simuli::cli {

/// The files of host/apps/cli/page/, as embedded at build time.
[[nodiscard]] std::span<const EmbeddedFile> page_files();

}  // namespace simuli::cli
