#pragma once
// The programs that a GPU's driver gets to compile: kernel files with their options.
#include <string>
#include <vector>

#include "host/device/runtime/build_options.hpp"

namespace simuli::test {

struct GpuProgram {
  std::string name;      // of a frame: "camera moving, order window"; of others: the file's
  std::string path;      // relative to cl/: "kernels/render.cl"
  BuildOptions options;  // those that the text names
};

/// In the shape of GPUs (a work-item a ray): six frames (camera and LiDAR: at rest, moving,
/// with actors in motion) with all kernels, each option of a frame changed alone, and what has no frame. None
/// twice. In double precision the six alone.
[[nodiscard]] std::vector<GpuProgram> gpu_programs();

}  // namespace simuli::test
