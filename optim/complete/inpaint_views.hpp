#pragma once
// The recorded frames of one set's sensors, and what is seen of a scene's background through them.
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
  std::vector<Eigen::Vector3f> origin, direction;  // [rays] m; unit, 0 where the lens has none
  std::vector<float> share;                        // [rays] of the frame at which it looks
};

inline constexpr double kMostPixels = 150'000.0;  // nothing fine is known behind actors

/// One recorded frame.
struct InpaintView {
  std::shared_ptr<const InpaintSensor> on;
  Shot shot;

  [[nodiscard]] const Sensor& sensor() const { return on->sensor; }
  /// The ray in the world; a direction of 0 where the lens has none.
  void ray(std::size_t index, Eigen::Vector3d& origin, Eigen::Vector3d& direction) const;
};

/// Where an actor was half-way through a view.
struct ActorBox {
  std::uint32_t actor = 0;  // 1 + its index
  Pose actor_from_world;
  Eigen::Vector3d center_world, half_m;

  [[nodiscard]] bool holds(const Eigen::Vector3d& p_world) const;
  /// What of a ray (world, direction of any length) lies in the box.
  [[nodiscard]] BoxInterval inside(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
};

/// Of the set's sensors those frames that training learned from, `most` of each at most, evenly spread; as
/// large as training saw them, or as has kMostPixels.
/// LiDARs that fire no rows of beams are left out: their rays have no neighbours.
[[nodiscard]] std::vector<InpaintView> inpaint_views(const Log& log,
                                               const FrameSelection& frames,
                                               SetKind kind,
                                               std::size_t most);

/// The boxes of the actors that are there, wider by `margin_m` to all sides.
[[nodiscard]] std::vector<ActorBox> boxes_in(const Scene& scene, const InpaintView& view, double margin_m);

/// [rays] 1 + the index of the actor that stands before it, 0: none. Kept as where it changes: of all views
/// at once there would be as much as of pictures.
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

/// Rays whose light mostly comes from an actor or from where its box is, and those next to them.
[[nodiscard]] ActorsBefore actors_before(SceneOnDevice& scene, const InpaintView& view);

/// What is seen of a scene without actors.
[[nodiscard]] RayRows rows_of(SceneOnDevice& background, const InpaintView& view, const ActorsBefore& actors);

/// Sums of the weights that background particles have in rays, and of what they look like there.
struct SeenWeights {
  Eigen::VectorXf before_actors, elsewhere;  // [N] in rays: in those that meet an actor, and in others
  Eigen::MatrixX3f look;                     // [N] features times `elsewhere`, from where each view sees them
};

/// `background`: particles without actors, of the set that the views see; their frame's origin in the world.
[[nodiscard]] SeenWeights seen_weights(const Device& device,
                                       const GaussianSet& background,
                                       const std::vector<InpaintView>& views,
                                       const std::vector<ActorsBefore>& actors,
                                       const Eigen::Vector3d& origin,
                                       const RenderOptions& render);

}  // namespace simuli
