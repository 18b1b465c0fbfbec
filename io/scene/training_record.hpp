#pragma once
// How a scene was made: the key "training" of scene.json.
#include <string>
#include <vector>

#include "io/log/frame_selection.hpp"

namespace simuli {

/// What it takes to make the scene again, and to know which frames it has not seen.
struct TrainingRecord {
  std::string log_name = {};
  std::string log_hash = {};  // io/log/log.hpp
  FrameSelection frames = {};
  std::vector<SensorUse> sensors = {};     // what that made of each one's frames; empty: not told
  int iterations = 0;                      // done
  int planned_iterations = 0;              // that the learning rates were made for
  std::string quality = {};                // the bundle that render.* are; "custom": none
  std::vector<std::string> settings = {};  // "key=value" of every option, as "simuli train --set" takes them
  std::string version = {};                // of simuli
  std::string device = {};
  std::string driver = {};
};

}  // namespace simuli
