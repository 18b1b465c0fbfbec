#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/device/runtime/device.hpp"

namespace simuli {

using ProgramBinary = std::vector<unsigned char>;

/// All inputs of a program binary as text: format version, platform, device, their versions,
/// driver version, options, expanded source. Stored in the cache file and compared in full.
[[nodiscard]] std::string program_key(const DeviceInfo& device,
                                      const std::string& options,
                                      const std::string& source);

/// Returns $SIMULI_CACHE_DIR, else $XDG_CACHE_HOME/simuli, else ~/.cache/simuli; no path (no cache) when
/// SIMULI_CACHE_DIR is set and empty or no home folder is known.
[[nodiscard]] std::optional<std::filesystem::path> cache_folder();

/// Returns the binary stored for `key`; no value when there is none or the file fails any check.
[[nodiscard]] std::optional<ProgramBinary> load_binary(const std::string& key);

/// Writes a binary to a temporary file and renames it. An unwritable cache is not an error.
void save_binary(const std::string& key, const ProgramBinary& binary);

/// Prepares PoCL's environment; call it before any OpenCL function. PoCL offers no device when its cache folder is
/// not writable (a read-only or full home): POCL_CACHE_DIR then becomes a temporary folder that is removed with
/// the process. After a recorded crash it becomes a new folder, because a damaged cache crashes every start.
/// PoCL also stops compiling each kernel twice (once for any launch size and once for the actual size); bits and
/// times stay the same. Variables that the user has set are not changed.
void prepare_driver_cache();
/// One line about these changes for the user of the program; empty without changes.
[[nodiscard]] std::string driver_cache_note();
/// Returns the cache folder of PoCL.
[[nodiscard]] std::filesystem::path driver_cache_folder();
/// Calls `install` now and after each program build: compilers in drivers (LLVM in PoCL) replace the process's
/// signal handlers, and their handler ends the process at a second signal.
void keep_installed(void (*install)());
void driver_has_built();
/// Returns the file that counts crashes and the count after the next crash, which the crash handler writes to
/// it. No value without a cache.
struct CrashCount {
  std::filesystem::path file;
  int next = 1;
};
[[nodiscard]] std::optional<CrashCount> crash_count();

}  // namespace simuli
