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

Scene trained(const Device& device, const Log& log, Scene start, const TrainOptions& options) {
  Trainer trainer(device, log, std::move(start), options);
  static_cast<void>(trainer.run());
  return trainer.scene();
}

}  // namespace simuli::bench
