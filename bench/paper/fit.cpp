#include "bench/paper/fit.hpp"

#include <stdlib.h>
#include <utility>

#include "host/base/error.hpp"

namespace simuli::bench {

ScratchFolder::ScratchFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "simuli-bench-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) {
    throw_input_error(pattern, "temporary folder", "one that can't be made", "a writable place (TMPDIR)");
  }
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;  // a destructor does not throw; what is left lies in the temporary folder
  std::filesystem::remove_all(path_, ignored);
}

SceneFile fit(const Device& device, const Log& log, const TrainingOptions& options) {
  Training training(device, log, options);
  training.run();
  return training.result();
}

EvalReport compare(const Device& device, const Log& log, const SceneFile& scene, EvalOptions options) {
  if (scene.training) {
    options.held_out_every = scene.training->frames.held_out_every;
    options.held_out_last = scene.training->frames.held_out_last;
  }
  return Evaluation(device, scene, log, options).run();
}

}  // namespace simuli::bench
