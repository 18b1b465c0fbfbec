#pragma once
// A running training in the browser (`simuli train --view`).
#include <memory>
#include <string>

#include "host/apps/cli/base/commands.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/train/train_report.hpp"

namespace simuli::cli {

/// Status of the training whose scene is shown.
struct ViewProgress {
  bool training = false;
  TrainStatus status;
  int iterations = 0;
};

/// The page; served until destruction.
class LivePage {
 public:
  LivePage() = default;
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;
  virtual ~LivePage() = default;

  /// Returns the page's address.
  [[nodiscard]] virtual std::string url() const = 0;
  /// Replaces the displayed scene.
  virtual void show(Scene scene) = 0;
  virtual void set_progress(const ViewProgress& progress) = 0;
  /// Returns the seconds since the last request of a page; infinity before the first.
  [[nodiscard]] virtual double idle_s() const = 0;
};

/// `file` may have empty sets before the training begins. port 0 selects a free one. Throws Error{kUsage} if it
/// cannot be bound, and in a build without the viewer.
[[nodiscard]] std::unique_ptr<LivePage> open_live_page(const Globals& globals, SceneFile file, int port);

}  // namespace simuli::cli
