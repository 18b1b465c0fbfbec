#pragma once
// Rendered frames as a recording of ROS 2: io/ros2/recording.hpp says what is in it.
#include <cstdint>
#include <filesystem>

#include "host/apps/cli/render/frame_files.hpp"
#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/frame.hpp"
#include "io/ros2/recording.hpp"

namespace simuli::cli {

/// Whether a file of this name is a recording: .mcap.
[[nodiscard]] bool is_bag(const std::filesystem::path& file);

/// Error{kUsage} for options that are of folders alone.
void need_options_of_bags(const FileOptions& options);

/// Zstandard where the build has it.
class RenderedBag {
 public:
  RenderedBag(const std::filesystem::path& file, Ros2Drive drive, const FileOptions& options);

  /// Frames in the order of their starts; `recorded` as of shown().
  void add(const Frame& frame, const RecordedViews* recorded);
  void finish() { recording_.finish(); }

 private:
  Ros2Recording recording_;
  BagPictures pictures_;
  CloudOptions cloud_;
};

}  // namespace simuli::cli
