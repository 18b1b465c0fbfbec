#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "host/apps/cli/base/commands.hpp"

namespace simuli::cli {

/// Shows progress(done, total) calls of io on stderr. The clock starts at construction; the first call sets
/// the total.
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
  void finish() { progress_.complete(); }

 private:
  Progress progress_;
};

/// Shows progress(stage, done, total) calls: one bar per stage, one after the other.
class StageProgress {
 public:
  explicit StageProgress(ProgressStyle style) : style_(style) {}
  void update(const std::string& stage, std::size_t done, std::size_t total) {
    if (!bar_ || stage != stage_) {
      finish();
      bar_.emplace(stage, total, style_);
      stage_ = stage;
    }
    bar_->update(done);
  }
  void finish() {
    if (bar_) bar_->complete();
    bar_.reset();
  }

 private:
  ProgressStyle style_;
  std::string stage_;
  std::optional<Progress> bar_;
};

}  // namespace simuli::cli
