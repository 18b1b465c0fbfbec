#pragma once
// The appearance of the camera set in training: environment and colour grids with their optimisers.
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
  std::vector<std::size_t> images;  // indices into log.images: whose grids they are; empty: none
  bool by_camera = false;           // one for all pictures of a camera
};
/// `training`: the log's training pictures.
[[nodiscard]] GridPlan plan_grids(const AppearanceOptions& options,
                                  const Log& log,
                                  const std::vector<std::size_t>& training);

class TrainedAppearance {
 public:
  /// The scene's environment, if it has one, and the grids of plan_grids(): the scene's own where it has just
  /// these, else the identity.
  TrainedAppearance(const Device& device, const Log& log, const Scene& scene, const TrainingOptions& options);

  [[nodiscard]] const EnvironmentBuffers* environment() const;
  /// Adam's epsilon for harmonics of colours: what a loss asks of them where they fill appearance.least_share of
  /// what each of so many particles has of a picture. Adam takes as long steps by traces of a gradient as by
  /// all of it.
  [[nodiscard]] double harmonics_epsilon(std::size_t particles) const;
  /// The pass through the grid of picture `image` (an index into log.images).
  void grade(Pass& pass, std::size_t image);
  /// Takes dL/d(graded picture) back to dL/d(outputs), and leaves the gradients of grid and environment.
  void backward(Pass& pass, std::size_t image);

  /// What backward() has left, for a step of several pictures; empty where there is none. Waits.
  struct Gradients {
    std::vector<float> grid, environment;
  };
  [[nodiscard]] Gradients gradients() const;
  /// Of a step on several pictures: moves the environment by their gradients' mean, added in their order by
  /// `sum`, and each grid by its own, in turn. Of one picture: by what backward() has left; `sum` is null.
  /// `iteration`: of the step, from 0; `iterations`: how many there will be.
  struct Shard {
    std::size_t image = 0;
    Gradients gradients;
  };
  void step(const std::vector<Shard>& shards, std::uint64_t iteration, int iterations, ShardSum* sum);

  /// Gradient entries that were not finite. Waits.
  [[nodiscard]] std::uint32_t rejected() const;
  void store(Scene& scene) const;
  /// What a checkpoint holds of it.
  void add_state(StateList& list);

 private:
  void step_grid(std::size_t image, std::uint64_t picture, double pictures, double progress);
  void step_environment(std::uint64_t iteration, double progress);
  /// Of colours [0,1] as they are, of one of so many parts of a picture.
  [[nodiscard]] double colour_epsilon(std::size_t parts) const;
  struct Environment {
    EnvironmentBuffers buffers;
    RealBuffer grads;
    AdamStage adam;
    std::vector<float> ground;  // texels [3] of the last rows, which are not learned; empty: all are
    bool is_dark = false;       // they are black for now

    void show_ground(bool is_black);
  };
  struct Grids {
    ColorGrids frames;                  // sizes and frames; the values stand on the device
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
