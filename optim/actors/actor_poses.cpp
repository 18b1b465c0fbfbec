#include "optim/actors/actor_poses.hpp"

#include <algorithm>
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
    add(time_start_s, gradients[i].shift_start, gradients[i].revolution_start);
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

std::vector<double> ActorPoses::numbers(const std::vector<Actor>& actors) const {
  std::vector<double> out;
  for (std::size_t i = 0; i < actors.size(); ++i) {
    for (std::size_t key = 0; key < actors[i].track.size(); ++key) {
      const bool moved = i < moments_.size() && key < moments_[i].size();
      const Moments m = moved ? moments_[i][key] : Moments{};
      out.insert(out.end(), m.first.begin(), m.first.end());
      out.insert(out.end(), m.second.begin(), m.second.end());
      out.push_back(m.steps);
    }
  }
  return out;
}

void ActorPoses::set_numbers(const std::vector<Actor>& actors, std::span<const double> numbers) {
  moments_.assign(actors.size(), {});
  for (std::size_t i = 0; i < actors.size(); ++i) {
    for (std::size_t key = 0; key < actors[i].track.size(); ++key) {
      Moments& m = moments_[i].emplace_back();
      std::copy_n(numbers.begin(), 6, m.first.begin());
      std::copy_n(numbers.begin() + 6, 6, m.second.begin());
      m.steps = static_cast<int>(numbers[12]);
      numbers = numbers.subspan(kNumbers);
    }
  }
}

}  // namespace simuli
