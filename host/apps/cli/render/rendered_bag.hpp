#pragma once
// Rendered frames as a ROS 2 recording (io/ros2/recording.hpp).
#include <cstdint>
#include <filesystem>

#include "host/apps/cli/render/frame_files.hpp"
#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/frame.hpp"
#include "io/ros2/recording.hpp"

namespace simuli::cli {

/// Whether a file of this name is a recording (.mcap).
[[nodiscard]] bool is_bag(const std::filesystem::path& file);

/// Throws Error{kUsage} for options that apply to folders only.
void need_options_of_bags(const FileOptions& options);

/// Writes a recording, compressed with Zstandard if the build supports it.
class RenderedBag {
 public:
  RenderedBag(const std::filesystem::path& file, Ros2Drive drive, const FileOptions& options);

  /// Adds a frame; frames must be in the order of their start times. `recorded` as in shown().
  void add(const Frame& frame, const RecordedViews* recorded);
  void finish() { recording_.finish(); }

 private:
  Ros2Recording recording_;
  BagPictures pictures_;
  CloudOptions cloud_;
};

}  // namespace simuli::cli
