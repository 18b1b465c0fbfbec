#pragma once
// A log as NCore, NVIDIA's format of recorded drives (version 4).
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

struct NcoreExport {
  std::size_t pictures = 0, sweeps = 0, boxes = 0;
  std::vector<std::string> left_out;  // what NCore has no name for
};

/// Writes one store, complete or not at all: a folder when the name ends in .zarr, one file when it ends in
/// .zarr.itar, the two names that NCore's own package reads. What NCore rounds or has no field for stands
/// beside it as "simuli" in generic_meta_data and in frames' generic_data: import_ncore() takes it from
/// there. Error{kInput} for other names, pictures that are neither PNG nor JPEG, frames of one sensor that
/// end in the same microsecond, and builds without libblosc and liblzma.
NcoreExport export_ncore(const Log& log,
                         const std::filesystem::path& output,
                         const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace simuli
