#pragma once

namespace simuli::cli {

/// Installs handlers. A crash prints one line to stderr and is counted (host/device/runtime/disk_cache.hpp),
/// then the process ends by its signal. An uncaught std::bad_alloc in a thread is no crash: it prints one
/// line and exits with code 71.
void watch_crashes();

}  // namespace simuli::cli
