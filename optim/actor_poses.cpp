#include "optim/actor_poses.hpp"

#include <cmath>
#include <map>

namespace simuli {
namespace {

constexpr double kBeta1 = 0.9;
constexpr double kBeta2 = 0.999;
constexpr double kEpsilon = 1e-15;

}  // namespace

void ActorPoses::step(std::vector<Actor>& actors,
                      const std::vector<ActorPoseGradient>& gradients,
                      double time_start_s,
                      double time_end_s,
                      double progress) {
  moments_.resize(actors.size());
  const double share = std::pow(rates_.final_share, progress);
  for (std::size_t i = 0; i < gradients.size(); ++i) {
    Actor& actor = actors[i];
    if (!actor.is_there(0.5 * (time_start_s + time_end_s))) continue;
    moments_[i].resize(actor.track.size());
    std::map<std::size_t, Vector6> by_key;
    const auto add = [&](double time_s, const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
      Vector6 g;
      g << shift, turn;
      if (g.isZero(0.0) || !g.allFinite()) return;
      const KeyShare at = actor.key_share(time_s);
      by_key.try_emplace(at.key, Vector6::Zero()).first->second += (1.0 - at.share) * g;
      if (at.share == 0.0) return;
      by_key.try_emplace(at.key + 1, Vector6::Zero()).first->second += at.share * g;
    };
    add(time_start_s, gradients[i].shift_start, gradients[i].turn_start);
    add(time_end_s, gradients[i].shift_end, gradients[i].turn_end);
    for (const auto& [key, g] : by_key) {
      Moments& m = moments_[i][key];
      ++m.steps;
      m.first = kBeta1 * m.first + (1.0 - kBeta1) * g;
      m.second = kBeta2 * m.second + (1.0 - kBeta2) * g.cwiseAbs2();
      const double bias1 = 1.0 - std::pow(kBeta1, m.steps);
      const double bias2 = 1.0 - std::pow(kBeta2, m.steps);
      const Vector6 step =
          (m.first / bias1).cwiseQuotient(((m.second / bias2).cwiseSqrt().array() + kEpsilon).matrix());
      actor.track[key].shift_m -= share * rates_.shift_m * step.head<3>();
      actor.track[key].turn_rad -= share * rates_.turn_rad * step.tail<3>();
    }
  }
}

}  // namespace simuli
