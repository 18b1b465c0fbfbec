#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "host/apps/cli/base/commands.hpp"

namespace simuli::cli {

/// Shows the progress(done, total) calls of io on stderr. The clock starts with the object, the total is
/// learnt from the first call.
class FileProgress {
 public:
  FileProgress(std::string label, const Globals& globals)
      : progress_(std::move(label), 0, progress_style(globals)) {}

  [[nodiscard]] std::function<void(std::size_t, std::size_t)> callback() {
    return [this](std::size_t done, std::size_t total) {
      progress_.set_total(total);
      progress_.update(done);
    };
  }
  void finish() { progress_.finish(); }

 private:
  Progress progress_;
};

}  // namespace simuli::cli
