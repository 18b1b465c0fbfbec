#pragma once
// A training in the browser while it runs: what `simuli train --view` shows.
#include <memory>
#include <string>

#include "host/apps/cli/base/commands.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/train/train_report.hpp"

namespace simuli::cli {

/// How a training stands whose scene is shown.
struct ViewProgress {
  bool training = false;
  TrainStatus status;
  int iterations = 0;
};

/// Served until it is destroyed.
class LivePage {
 public:
  LivePage() = default;
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;
  virtual ~LivePage() = default;

  /// Where the page is.
  [[nodiscard]] virtual std::string url() const = 0;
  /// From now on this scene is shown.
  virtual void show(Scene scene) = 0;
  virtual void set_progress(const ViewProgress& progress) = 0;
  /// Seconds since a page last asked for anything; infinite before.
  [[nodiscard]] virtual double idle_s() const = 0;
};

/// `file` may have empty sets: the training has not begun. port 0: any free one. Error{kUsage} when it can't
/// be bound, and in a build without the viewer.
[[nodiscard]] std::unique_ptr<LivePage> open_live_page(const Globals& globals, SceneFile file, int port);

}  // namespace simuli::cli
