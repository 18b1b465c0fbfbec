#pragma once
// What the benches that train scenes share.
#include <filesystem>
#include <functional>
#include <string>

#include "host/runtime/device.hpp"
#include "io/log/log.hpp"
#include "optim/eval/evaluate.hpp"
#include "optim/init/initialize.hpp"
#include "optim/train/trainer.hpp"

namespace simuli::bench {

/// Says one line to whoever waits.
using Note = std::function<void(const std::string&)>;

/// A new folder below the temporary one, removed with all that is in it. Error{kInput} when it can't be made.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ScratchFolder(ScratchFolder&&) = delete;
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Trains `start` on the frames of `log` that are not held out.
[[nodiscard]] Scene trained(const Device& device, const Log& log, Scene start, const TrainOptions& options);

}  // namespace simuli::bench
