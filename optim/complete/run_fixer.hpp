#pragma once
// The protocol by which a program of the user's mends pictures: a folder in, a folder out (docs/FIXERS.md).
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
  double left_m = 0.0;  // of the recorded path
  Image rendered;       // [height][width][3] in [0, 1]
  Image support;        // [height][width][1] in [0, 1]
  Image recorded;       // the picture that was taken on the path then
};

/// Writes the views into a folder of their own, runs `COMMAND IN OUT` by the shell, waits for it, and reads
/// what it wrote to OUT: one picture per view, in their order. Error{kInput} in one line when it can't be
/// run, ends with another code than 0, or leaves other files than NAME.png of each view, of the view's size.
/// The folders go.
[[nodiscard]] std::vector<Image> run_fixer(const std::string& command,
                                           const std::vector<FixerView>& views,
                                           int iteration);

}  // namespace simuli
