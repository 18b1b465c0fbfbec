#pragma once
// Protocol of external programs that repair pictures: an input folder and an output folder (docs/FIXERS.md).
#include <string>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/core/base/pose.hpp"
#include "host/core/sensors/camera.hpp"

namespace simuli {

/// A picture to repair.
struct FixerView {
  std::string name;  // of its files, without ".png"
  Camera camera;     // of the picture's size
  Pose world_from_camera;
  double time_s = 0.0;
  double left_m = 0.0;  // offset to the left of the recorded path
  Image rendered;       // [height][width][3] in [0, 1]
  Image support;        // [height][width][1] in [0, 1]
  Image recorded;  // recorded picture on the path at that time
};

/// Writes the views to a temporary folder, runs `COMMAND IN OUT` by the shell, and reads one picture per view
/// from OUT, in order. Throws Error{kInput} with one line when the program cannot be run, ends with a code
/// other than 0, or does not write exactly NAME.png of each view in the view's size. Removes the folders.
[[nodiscard]] std::vector<Image> run_fixer(const std::string& command,
                                           const std::vector<FixerView>& views,
                                           int iteration);

}  // namespace simuli
