#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/runtime/device.hpp"

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

}  // namespace simuli
