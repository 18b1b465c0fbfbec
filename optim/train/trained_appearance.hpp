#pragma once
// Appearance of the camera set in training: environment map, colour grids and their optimisers.
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "host/device/render/train/adam.hpp"
#include "host/device/render/train/shard_sum.hpp"
#include "io/log/log.hpp"
#include "optim/base/state.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

/// The colour grids of a training (METHOD section 9).
struct GridPlan {
  static constexpr std::array<int, 3> kSize{16, 16, 8};  // vertices along x, y and luminance
  std::vector<std::size_t> images;  // indices into log.images, one per grid; empty: no grids
  bool by_camera = false;  // one grid for all pictures of a camera
};
/// `training`: the training pictures of the log.
[[nodiscard]] GridPlan plan_grids(const AppearanceOptions& options,
                                  const Log& log,
                                  const std::vector<std::size_t>& training);

class TrainedAppearance {
 public:
  /// Starts with the scene's environment, if any, and the grids of plan_grids(): the scene's grids where they
  /// match, else identities.
  TrainedAppearance(const Device& device, const Log& log, const Scene& scene, const TrainingOptions& options);

  [[nodiscard]] const EnvironmentBuffers* environment() const;
  /// Returns Adam's epsilon of SH coefficients: the gradient of a particle that fills the share
  /// appearance.least_share of an average particle's picture area. Without it Adam takes full steps even for
  /// tiny gradients.
  [[nodiscard]] double harmonics_epsilon(std::size_t particles) const;
  /// Applies the grid of picture `image` (an index into log.images) to the pass.
  void grade(Pass& pass, std::size_t image);
  /// Backpropagates dL/d(corrected picture) to dL/d(outputs), and stores the gradients of grid and environment.
  void backward(Pass& pass, std::size_t image);

  /// Gradients of backward() for a step with several shards; empty where there are none. Waits.
  struct Gradients {
    std::vector<float> grid, environment;
  };
  [[nodiscard]] Gradients gradients() const;
  /// Takes the step. Several shards: the environment moves by the mean gradient, added in order by `sum`, and
  /// each grid by its own gradient in turn. One shard: uses the gradients of backward(), `sum` is null.
  /// `iteration` from 0 of `iterations`.
  struct Shard {
    std::size_t image = 0;
    Gradients gradients;
  };
  void step(const std::vector<Shard>& shards, std::uint64_t iteration, int iterations, ShardSum* sum);

  /// Returns the number of non-finite gradient entries. Waits.
  [[nodiscard]] std::uint32_t rejected() const;
  void store(Scene& scene) const;
  /// Adds the checkpoint state.
  void add_state(StateList& list);

 private:
  void step_grid(std::size_t image, std::uint64_t picture, double pictures, double progress);
  void step_environment(std::uint64_t iteration, double progress);
  /// Epsilon of colours in [0, 1] for one of so many parts of a picture.
  [[nodiscard]] double colour_epsilon(std::size_t parts) const;
  struct Environment {
    EnvironmentBuffers buffers;
    RealBuffer grads;
    AdamStage adam;
    std::vector<float> ground;  // [3] texels of the last rows, which are not trained; empty: all rows are
    bool is_dark = false;  // currently black

    void show_ground(bool is_black);
  };
  struct Grids {
    ColorGrids frames;  // sizes and frames; values are on the device
    std::vector<std::size_t> of_image;  // [log.images]
    ColorGridBuffers buffers;
    RealBuffer grads;  // of one grid
    AdamStage adam;
  };

  AppearanceOptions options_;
  std::optional<Environment> environment_;
  std::optional<Grids> grids_;
};

}  // namespace simuli
