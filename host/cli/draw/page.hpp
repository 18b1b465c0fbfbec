#pragma once
#include <span>

#include "host/runtime/text/source.hpp"

namespace simuli::cli {

/// The files of host/cli/draw/page/, as embedded at build time.
[[nodiscard]] std::span<const EmbeddedFile> report_files();

}  // namespace simuli::cli
