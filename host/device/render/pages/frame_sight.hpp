#pragma once
// Conservative visibility test of particles on the host, before they are uploaded.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cl/shared/sensor_constants.h"
#include "host/device/render/frame/particle_clusters.hpp"
#include "host/device/render/options/options.hpp"
#include "host/device/render/rays/ray_grid.hpp"

namespace simuli {

/// Bounds of particles of one actor or of the background: a ball that contains their means in the axes of their
/// parameters (m), their largest log-scale and opacity logit, and their smallest and largest level of detail.
struct ParticleBounds {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
  double log_scale = 0.0;
  double opacity_logit = 0.0;
  double from_m = 0.0, until_m = 0.0;
  std::uint32_t actor = 0;

  /// Returns the bounds of one of `clusters`.
  [[nodiscard]] static ParticleBounds of(const ParticleClusters& clusters, std::size_t cluster);
  /// Extends the bounds by `other` of the same actor.
  void include(const ParticleBounds& other);
};

/// A sensor in one frame, with the actors in that frame.
class FrameSight {
 public:
  /// `actors`: the ActorConstants of the frame by actor_constants(); empty for sets without actors.
  FrameSight(SensorType type,
             const shared::SensorConstants<double>& sensor,
             bool detail,
             const std::vector<double>& actors);

  /// Returns true wherever cluster_may_be_seen() of cl/math/cluster_culling.h does.
  [[nodiscard]] bool may_see(const ParticleBounds& bounds) const;

 private:
  SensorType type_;
  shared::SensorConstants<double> sensor_;
  bool detail_;
  std::vector<shared::ActorConstants<double>> actors_;
  double path_m_ = 0.0;  // path length of the sensor during the frame
  double origin_reach_m_ = 0.0;  // largest distance of ray origins from o_ref
};

}  // namespace simuli
