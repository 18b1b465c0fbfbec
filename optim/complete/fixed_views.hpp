#pragma once
// Off-trajectory views for training, repaired by an external program.
#include <cstddef>
#include <string>
#include <vector>

#include "host/device/render/scene/renderer.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/complete/fixer_options.hpp"
#include "optim/base/state.hpp"

namespace simuli {

/// A repaired view.
struct FixedView {
  std::string camera;  // of the log
  Shot shot;
  double left_m = 0.0;
  std::size_t frame = 0;      // index into log.images
  std::vector<float> values;  // [3][pixels], -1: not used
  std::size_t known = 0;      // pixels
};

/// Schedules repairs and stores repaired views. A pixel is used with a probability of 1 minus its support,
/// drawn once per picture and pixel: where recorded pictures support the view they are better supervision.
class FixedViews {
 public:
  /// Inactive without a command. `log` must outlive this object.
  FixedViews(const Device& device,
             const Log& log,
             const FrameSelection& frames,
             const FixerOptions& options,
             std::string command,
             const RenderOptions& render);

  /// Whether the program is due before this iteration of `iterations`.
  [[nodiscard]] bool is_due(int iteration, int iterations) const;
  /// Renders views of the current scene, has them repaired, and stores the results. Throws as run_fixer().
  void repair(const SceneFile& scene, int iteration);
  /// Returns the view for this iteration; null without one.
  [[nodiscard]] const FixedView* turn(int iteration) const;
  /// Weight of its loss relative to a recorded picture's.
  [[nodiscard]] double weight() const { return options_.weight; }
  /// Adds the checkpoint state.
  void add_state(StateList& list);

 private:
  [[nodiscard]] std::vector<FixedView> planned() const;

  Device device_;
  const Log& log_;
  FrameSelection frames_;
  FixerOptions options_;
  std::string command_;
  RenderOptions render_;
  std::vector<FixedView> views_;
};

}  // namespace simuli
