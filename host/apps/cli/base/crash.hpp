#pragma once

namespace simuli::cli {

/// A crash is one line on stderr, too, and is counted (host/device/runtime/disk_cache.hpp); then the process
/// ends as it would have. A thread that ends the process for want of memory is none: one line, exit code 71.
void watch_crashes();

}  // namespace simuli::cli
