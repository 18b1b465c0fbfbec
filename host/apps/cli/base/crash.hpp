#pragma once

namespace simuli::cli {

/// A crash is one line on stderr, too, and is counted (host/device/runtime/disk_cache.hpp); then the process
/// ends as it would have.
void watch_crashes();

}  // namespace simuli::cli
