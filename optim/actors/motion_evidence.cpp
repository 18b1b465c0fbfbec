#include "optim/actors/motion_evidence.hpp"

#include <array>
#include <cstddef>

namespace simuli {
namespace {

/// Offsets in sweeps: near ones for fast objects, far ones for slow objects.
constexpr std::array<std::size_t, 8> kSteps{1, 2, 3, 5, 7, 10, 14, 19};
constexpr int kLeast = 3;  // number of agreeing sweeps

/// Votes of the sweeps on one side, from near to far.
struct Side {
  std::uint8_t through = 0;
  std::uint8_t there = 0;
  std::uint8_t last_through = 0;  // since a sweep last hit something

  void add(const PointVotes& vote) {
    if (vote.through > 0) {
      ++through;
      ++last_through;
    } else if (vote.there > 0) {
      ++there;
      last_through = 0;
    }
  }
  [[nodiscard]] bool is_clear() const {
    return last_through >= kLeast || (through >= kLeast && through >= 3 * there);
  }
};

Motion judged(const Side& before, const Side& after) {
  if (before.is_clear() || after.is_clear()) return Motion::kMoves;
  const int there = before.there + after.there, through = before.through + after.through;
  return there >= kLeast && there >= 4 * through ? Motion::kStands : Motion::kUnknown;
}

}  // namespace

std::vector<std::vector<Motion>> motion_evidence(const SweepSeries& series) {
  std::vector<std::vector<Motion>> out;
  for (std::size_t i = 0; i < series.sweeps.size(); ++i) {
    const PointSet& points = series.sweeps[i].points;
    std::vector<Side> before(points.size()), after(points.size());
    const auto ask = [&](std::size_t other, std::vector<Side>& side) {
      std::vector<PointVotes> votes(points.size());
      series.vote(other, points, votes);
      for (std::size_t k = 0; k < votes.size(); ++k) side[k].add(votes[k]);
    };
    for (const std::size_t step : kSteps) {
      if (step <= i) ask(i - step, before);
      if (i + step < series.sweeps.size()) ask(i + step, after);
    }
    std::vector<Motion>& motion = out.emplace_back();
    for (std::size_t k = 0; k < points.size(); ++k) motion.push_back(judged(before[k], after[k]));
  }
  return out;
}

}  // namespace simuli
