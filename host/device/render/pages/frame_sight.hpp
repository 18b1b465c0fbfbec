#pragma once
// Whether a frame may see any of some particles, asked on the host before they are on the device.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cl/shared/sensor_constants.h"
#include "host/device/render/frame/particle_clusters.hpp"
#include "host/device/render/options/options.hpp"
#include "host/device/render/rays/ray_grid.hpp"

namespace simuli {

/// Bounds of some particles of one actor, or of the background: a ball that holds their means, in the axes
/// that they are given in (m), the largest of their log-scales and opacity logits, the least and the largest
/// of their levels of detail.
struct ParticleBounds {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
  double log_scale = 0.0;
  double opacity_logit = 0.0;
  double from_m = 0.0, until_m = 0.0;
  std::uint32_t actor = 0;

  /// Of one of `clusters`.
  [[nodiscard]] static ParticleBounds of(const ParticleClusters& clusters, std::size_t cluster);
  /// Around both, which are of the same actor.
  void include(const ParticleBounds& other);
};

/// A sensor in one frame, with the actors as they are in it.
class FrameSight {
 public:
  /// `actors`: the ActorConstants of the frame as actor_constants() gives them; empty for sets without any.
  FrameSight(SensorType type,
             const shared::SensorConstants<double>& sensor,
             bool detail,
             const std::vector<double>& actors);

  /// cluster_may_be_seen() of cl/math/cluster_culling.h: true wherever that is.
  [[nodiscard]] bool may_see(const ParticleBounds& bounds) const;

 private:
  SensorType type_;
  shared::SensorConstants<double> sensor_;
  bool detail_;
  std::vector<shared::ActorConstants<double>> actors_;
  double path_m_ = 0.0;          // of the sensor during the frame
  double origin_reach_m_ = 0.0;  // ray origins are at most this far from o_ref
};

}  // namespace simuli
