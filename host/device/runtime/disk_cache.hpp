#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/device/runtime/device.hpp"

namespace simuli {

using ProgramBinary = std::vector<unsigned char>;

/// Everything a program binary depends on, as text: format version, platform, device, their versions,
/// driver version, options, expanded source. Stored in the cache file and compared in full.
[[nodiscard]] std::string program_key(const DeviceInfo& device,
                                      const std::string& options,
                                      const std::string& source);

/// $SIMULI_CACHE_DIR, else $XDG_CACHE_HOME/simuli, else ~/.cache/simuli; nothing (no cache) when
/// SIMULI_CACHE_DIR is set and empty, or when there is no home.
[[nodiscard]] std::optional<std::filesystem::path> cache_folder();

/// The binary stored for `key`; nothing when there is none or the file is anything but exact.
[[nodiscard]] std::optional<ProgramBinary> load_binary(const std::string& key);

/// Stores a binary under a temporary name and renames it. A cache that can't be written is no error.
void save_binary(const std::string& key, const ProgramBinary& binary);

/// PoCL keeps what it compiles in a folder of its own and is no device at all where it can't write there. To
/// be called before OpenCL is: where PoCL could not (a read-only or full home) it is given, by
/// POCL_CACHE_DIR, a temporary folder that goes with the process; and another folder after each crash that
/// was counted, as a damaged one ends every start. Nor does PoCL compile each kernel twice, for any size of
/// launch, as its binaries want it, and for the size that it is launched with: the bits are the same, and so are
/// times. Nothing is changed where the variables are set.
void prepare_driver_cache();
/// What of that whoever runs the program should know, one line; empty: nothing.
[[nodiscard]] std::string driver_cache_note();
/// Where PoCL keeps what it compiles.
[[nodiscard]] std::filesystem::path driver_cache_folder();
/// Calls `install` now and whenever a driver has built a program: compilers in drivers (LLVM in PoCL) put
/// their own handlers of signals in the place of everybody's, and a second signal ends the process while they
/// are at the first.
void keep_installed(void (*install)());
void driver_has_built();
/// The file that counts crashes and the count after the next one; whoever notices a crash writes it there.
/// Nothing where there is no cache.
struct CrashCount {
  std::filesystem::path file;
  int next = 1;
};
[[nodiscard]] std::optional<CrashCount> crash_count();

}  // namespace simuli
