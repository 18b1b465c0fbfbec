#pragma once
// Recorded frames of one set's sensors, and the scene's background as they see it.
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "host/device/render/scene/scene_on_device.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/base/evaluate_actors.hpp"
#include "optim/complete/inpaint_rows.hpp"

namespace simuli {

/// A sensor's rays in its own frame.
struct InpaintSensor {
  explicit InpaintSensor(Sensor of);
  Sensor sensor;
  std::vector<Eigen::Vector3f> origin, direction;  // [rays] m; unit, 0 without a ray through the lens
  std::vector<float> share;  // [rays] share of the frame at the ray's time
};

inline constexpr double kMostPixels = 150'000.0;  // nothing fine is known behind actors

/// One recorded frame.
struct InpaintView {
  std::shared_ptr<const InpaintSensor> on;
  Shot shot;

  [[nodiscard]] const Sensor& sensor() const { return on->sensor; }
  /// Computes the ray in the world; a zero direction without a ray through the lens.
  void ray(std::size_t index, Eigen::Vector3d& origin, Eigen::Vector3d& direction) const;
};

/// An actor's box at the middle of a view.
struct ActorBox {
  std::uint32_t actor = 0;  // 1 + the actor's index
  Pose actor_from_world;
  Eigen::Vector3d center_world, half_m;

  [[nodiscard]] bool holds(const Eigen::Vector3d& p_world) const;
  /// Returns the interval of a ray (world, direction of any length) inside the box.
  [[nodiscard]] BoxInterval inside(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
};

/// Returns training frames of the set's sensors, at most `most` of each, evenly spread, at the training size or
/// kMostPixels. LiDARs without rows are left out: their rays have no known neighbours.
[[nodiscard]] std::vector<InpaintView> inpaint_views(const Log& log,
                                               const FrameSelection& frames,
                                               SetKind kind,
                                               std::size_t most);

/// Returns the boxes of the actors present, enlarged by `margin_m`.
[[nodiscard]] std::vector<ActorBox> boxes_in(const Scene& scene, const InpaintView& view, double margin_m);

/// [rays] 1 + the index of the occluding actor, 0: none. Stored as run lengths, because all views together
/// would be as large as the pictures.
class ActorsBefore {
 public:
  ActorsBefore() = default;
  explicit ActorsBefore(const std::vector<std::uint32_t>& of_rays);
  [[nodiscard]] std::vector<std::uint32_t> of(std::size_t rays) const;
  [[nodiscard]] bool any() const { return !changes_.empty(); }

 private:
  struct Change {
    std::size_t ray;
    std::uint32_t actor;
  };
  std::vector<Change> changes_;
};

/// Finds rays whose light mostly comes from an actor or its box, and their neighbours.
[[nodiscard]] ActorsBefore actors_before(SceneOnDevice& scene, const InpaintView& view);

/// Renders a view without actors.
[[nodiscard]] RayRows rows_of(SceneOnDevice& background, const InpaintView& view, const ActorsBefore& actors);

/// Sums of the weights of background particles in rays, and of their appearance there.
struct SeenWeights {
  Eigen::VectorXf before_actors, elsewhere;  // [N] in rays through an actor, and in other rays
  Eigen::MatrixX3f look;  // [N] features times `elsewhere`, as seen from each view
};

/// `background`: particles without actors of the set that the views use, and their frame's origin in the world.
[[nodiscard]] SeenWeights seen_weights(const Device& device,
                                       const GaussianSet& background,
                                       const std::vector<InpaintView>& views,
                                       const std::vector<ActorsBefore>& actors,
                                       const Eigen::Vector3d& origin,
                                       const RenderOptions& render);

}  // namespace simuli
