#pragma once
// Export of logs in NCore, NVIDIA's format of recorded drives (version 4).
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

struct NcoreExport {
  std::size_t pictures = 0, sweeps = 0, boxes = 0;
  std::vector<std::string> left_out;  // parts that NCore does not support
};

/// Writes one store atomically: a folder for names ending in .zarr, one file for names ending in .zarr.itar;
/// NCore's package reads both. Values that NCore rounds or lacks are stored as "simuli" in generic_meta_data
/// and in frames' generic_data, from which import_ncore() restores them. Throws Error{kInput} for other names,
/// pictures that are neither PNG nor JPEG, two frames of a sensor that end in the same microsecond, and builds
/// without libblosc and liblzma.
NcoreExport export_ncore(const Log& log,
                         const std::filesystem::path& output,
                         const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace simuli
