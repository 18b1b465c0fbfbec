#include "host/device/render/pages/frame_sight.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "cl/shared/cluster.h"
#include "host/core/base/error.hpp"

namespace simuli {
namespace {

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// CLUSTER_MARGIN of cl/math/cluster_culling.h: the rounding of particle positions in the device's tests.
constexpr double kMargin = 4e-3;

}  // namespace

ParticleBounds ParticleBounds::of(const ParticleClusters& clusters, std::size_t cluster) {
  const auto row = [&](std::size_t k) {
    return static_cast<double>(clusters.bounds[k * clusters.stride + cluster]);
  };
  return {{row(SIM_C_CENTRE), row(SIM_C_CENTRE + 1), row(SIM_C_CENTRE + 2)},
          row(SIM_C_RADIUS),
          row(SIM_C_LOG_SCALE),
          row(SIM_C_OPACITY),
          row(SIM_C_FROM),
          row(SIM_C_UNTIL),
          clusters.actor[cluster]};
}

void ParticleBounds::include(const ParticleBounds& other) {
  const Eigen::Vector3d away = other.centre - centre;
  const double apart = away.norm();
  if (apart + other.radius_m > radius_m) {
    const double larger = std::max(0.5 * (radius_m + apart + other.radius_m), other.radius_m);
    // Moves the centre towards the other ball as far as this ball stays inside; rounding is far below the
    // margin.
    if (apart > 0.0) centre += away * std::min(std::max(larger - radius_m, 0.0) / apart, 1.0);
    radius_m = larger;
  }
  log_scale = std::max(log_scale, other.log_scale);
  opacity_logit = std::max(opacity_logit, other.opacity_logit);
  from_m = std::min(from_m, other.from_m);
  until_m = std::max(until_m, other.until_m);
}

FrameSight::FrameSight(SensorType type,
                       const shared::SensorConstants<double>& sensor,
                       bool detail,
                       const std::vector<double>& actors)
    : type_(type), sensor_(sensor), detail_(detail) {
  constexpr std::size_t kEach = shared::kReals<shared::ActorConstants>;
  for (std::size_t first = 0; first < actors.size(); first += kEach) {
    std::array<double, kEach> reals{};
    std::copy_n(actors.begin() + static_cast<std::ptrdiff_t>(first), kEach, reals.begin());
    actors_.push_back(shared::from_reals<shared::ActorConstants>(reals));
  }
  const Eigen::Vector3d step(sensor.centre_step);
  path_m_ = step.norm();
  const auto& m = sensor.model;
  // Rays fire during the frame, except for the deviation of a LiDAR's beams from the time of their x.
  origin_reach_m_ = m.lever + std::abs(m.height) + (1.0 + m.time_spread) * step.lpNorm<1>();
}

bool FrameSight::may_see(const ParticleBounds& bounds) const {
  const Eigen::Vector3d centre_ref(sensor_.centre_ref);
  Eigen::Vector3d offset = bounds.centre - centre_ref;
  double means = bounds.radius_m;
  const shared::ActorConstants<double>* actor = nullptr;
  if (bounds.actor > 0) {
    if (bounds.actor >= actors_.size()) {
      throw Error(ErrorKind::kInternal, "pages: particles of an actor that the frame does not have");
    }
    actor = &actors_[bounds.actor];
    if (actor->there == 0.0) return false;
    offset = Eigen::Vector3d(actor->centre) + Matrix(actor->rotation) * bounds.centre;
    means += actor->reach;
  }
  const double distance = offset.norm(), farthest = distance + means;
  const double logit = std::clamp(bounds.opacity_logit, -80.0, 80.0);
  const double qmax = 1e-3 - 2.0 * (std::log1p(std::exp(-logit)) + std::log(sensor_.alpha_cut));
  if (qmax <= 0.0) return false;
  const auto& model = sensor_.model;
  const double scale = std::exp(bounds.log_scale);
  const double widest = std::sqrt(scale * scale + farthest * farthest * model.kappa);
  const double radius = 1.001 * std::sqrt(qmax) * widest;
  double travel = 0.0;
  if (actor != nullptr) {
    const double arm = (offset - Eigen::Vector3d(actor->centre)).norm();
    travel = Eigen::Vector3d(actor->step).norm() + actor->turn_angle * (arm + means + radius);
  }
  double ball = means + radius + 0.5 * travel + kMargin * farthest;
  if (distance - ball >= model.t_max + origin_reach_m_) return false;
  if (detail_) {
    const double slack = means + kMargin * farthest;
    if (distance + slack <= sensor_.detail_reach * bounds.from_m) return false;
    if (distance - slack >= SIM_DETAIL_FADE * sensor_.detail_reach * bounds.until_m) return false;
  }
  if (type_ != SensorType::kCamera) return true;
  ball += 0.5 * path_m_;
  const double tangent2 = distance * distance - ball * ball;
  if (!(tangent2 > 0.0)) return true;
  const double tangent = std::sqrt(tangent2);
  const bool part_way = tangent * sensor_.sin_view + ball * sensor_.cos_view > 0.0;
  const double depth = Matrix(sensor_.rotation_ref).row(2).dot(offset);
  return !(part_way && depth < tangent * sensor_.cos_view - ball * sensor_.sin_view);
}

}  // namespace simuli
