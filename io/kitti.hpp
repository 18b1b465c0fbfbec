#pragma once
#include <filesystem>
#include <functional>
#include <string>

#include "io/log.hpp"

namespace simuli {

struct KittiOptions {
  /// Folder of one drive (".../2011_09_26_drive_0013_sync"), calibration in its parent.
  std::filesystem::path drive;
  /// JSON with "frames": [{"index", "world_from_velo" 4x4 at "t_sweep_forward", ...}]; empty: poses from
  /// oxts, interpolated by timestamp.
  std::filesystem::path poses;
  std::filesystem::path output;
};

/// Imports a KITTI raw drive (left colour camera, HDL-64E, oxts) and writes the log folder. The output
/// appears complete or not at all. `progress(done, total)` is called after every frame.
Log import_kitti(const KittiOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli
