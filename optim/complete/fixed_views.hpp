#pragma once
// Views beside the path in training, repaired by a program of the user's.
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

/// What a step learns from.
struct FixedView {
  std::string camera;  // of the log
  Shot shot;
  double left_m = 0.0;
  std::size_t frame = 0;      // index into log.images
  std::vector<float> values;  // [3][pixels], -1: not learned from
  std::size_t known = 0;      // pixels
};

/// Which pictures are repaired, when, and what came of it. A pixel is learned from with a probability of one
/// less its support, drawn once for each picture and pixel: what recorded pictures tell, they tell better.
class FixedViews {
 public:
  /// No command: there are none. `log` must outlive it.
  FixedViews(const Device& device,
             const Log& log,
             const FrameSelection& frames,
             const FixerOptions& options,
             std::string command,
             const RenderOptions& render);

  /// Whether the program is to be asked before this iteration of `iterations`.
  [[nodiscard]] bool is_due(int iteration, int iterations) const;
  /// Renders the views of the scene as it is, has them repaired, and keeps what comes back. Errors as
  /// run_fixer().
  void repair(const SceneFile& scene, int iteration);
  /// The view to learn from in this iteration; null: none.
  [[nodiscard]] const FixedView* turn(int iteration) const;
  /// Of its loss over that of a recorded picture.
  [[nodiscard]] double weight() const { return options_.weight; }
  /// What a checkpoint holds of it.
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
