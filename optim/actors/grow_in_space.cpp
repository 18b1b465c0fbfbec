// Extends a body's box to connected parts that move with it.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "optim/actors/body_track.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using BodyCell = std::array<int, 3>;

constexpr double kBodyVoxel_m = 0.4;
const Vector3d kReach_m(6.0, 1.0, 1.0);  // beyond the box, per round
constexpr int kGrowthRounds = 5;
constexpr double kGrown_m = 0.3;                  // smaller growth ends the iteration
constexpr std::size_t kVotingSweeps = 12;         // sweeps that vote, of those that saw the body
constexpr std::size_t kVotersOfAVoxel = 12;       // returns of a voxel that are voted on
constexpr std::size_t kLeastReturnsOfAVoxel = 3;  // of a voxel
constexpr int kGapX = 2, kGapY = 1, kGapZ = 2;    // empty voxels that may be bridged: windows, a coupling
constexpr double kStray = 0.004;                  // share of the returns outside each side of the box

struct Voxel {
  std::size_t returns = 0, standing = 0;
  std::set<std::size_t> sweeps;
  std::size_t through = 0, there = 0;
};

BodyCell cell_of(const Vector3d& p) {
  const Eigen::Vector3i c = (p / kBodyVoxel_m).array().floor().cast<int>();
  return {c.x(), c.y(), c.z()};
}

/// Voxels around a box that move with the body.
class Growth {
 public:
  Growth(const SweepSeries& series,
         const BodyTrack& track,
         const std::vector<std::vector<Motion>>& motion,
         const TakenReturns& taken)
      : track_(track) {
    Eigen::AlignedBox3d region = track.box;
    region.min() -= Vector3d(kReach_m.x(), kReach_m.y(), 0.0);
    region.max() += kReach_m;
    region.max().z() = std::min(region.max().z(), kHighest_m);
    returns_ = all_returns(series, track, region, taken);
    std::vector<Voxel*> voxel_of;
    for (const BodyReturn& r : returns_) {
      Voxel& v = voxels_[cell_of(r.p_body)];
      voxel_of.push_back(&v);
      ++v.returns;
      const std::size_t sweep = track.sweeps[r.key];
      v.standing += motion[sweep][r.point] == Motion::kStands ? 1U : 0U;
      v.sweeps.insert(sweep);
    }
    std::vector<std::size_t> requested;
    std::map<const Voxel*, std::size_t> met;
    for (std::size_t i = 0; i < returns_.size(); ++i) {
      if (met[voxel_of[i]]++ % (voxel_of[i]->returns / kVotersOfAVoxel + 1) == 0) requested.push_back(i);
    }
    PointSet points;
    points.position.resize(3, static_cast<Eigen::Index>(requested.size()));
    points.intensity.assign(requested.size(), 0.0F);
    for (std::size_t k = 0; k < requested.size(); ++k)
      points.position.col(static_cast<Eigen::Index>(k)) = returns_[requested[k]].p_body.cast<float>();
    const std::vector<PointVotes> votes = votes_along(series, track, points, kVotingSweeps);
    for (std::size_t k = 0; k < requested.size(); ++k) {
      voxel_of[requested[k]]->through += votes[k].through;
      voxel_of[requested[k]]->there += votes[k].there;
    }
  }

  /// Box of the voxels connected to the known ones.
  [[nodiscard]] Eigen::AlignedBox3d box() const {
    std::set<BodyCell> reached;
    std::vector<BodyCell> open;
    for (const auto& [cell, voxel] : voxels_) {
      const Vector3d middle = kBodyVoxel_m * (Vector3d(cell[0], cell[1], cell[2]).array() + 0.5).matrix();
      if (!track_.box.contains(middle) || !moves_along(cell, voxel)) continue;
      reached.insert(cell);
      open.push_back(cell);
    }
    while (!open.empty()) {
      const BodyCell at = open.back();
      open.pop_back();
      for (int dx = -kGapX; dx <= kGapX; ++dx) {
        for (int dy = -kGapY; dy <= kGapY; ++dy) {
          for (int dz = -kGapZ; dz <= kGapZ; ++dz) {
            const BodyCell next{at[0] + dx, at[1] + dy, at[2] + dz};
            const auto voxel = voxels_.find(next);
            if (voxel == voxels_.end() || reached.contains(next) || !moves_along(next, voxel->second))
              continue;
            reached.insert(next);
            open.push_back(next);
          }
        }
      }
    }
    return around(reached);
  }

 private:
  /// A voxel that seems static may be a side that slides along itself, but only where the body passes anyway.
  [[nodiscard]] bool moves_along(const BodyCell& cell, const Voxel& v) const {
    const std::size_t sweeps = std::clamp<std::size_t>(track_.keys() / 6, 2, 5);
    if (v.returns < kLeastReturnsOfAVoxel || v.sweeps.size() < sweeps) return false;
    if (v.there == 0 || v.there < 4 * v.through) return false;
    const double y = (cell[1] + 0.5) * kBodyVoxel_m;
    const bool beside = y < track_.box.min().y() - 0.2 || y > track_.box.max().y() + 0.2;
    return !beside || 2 * v.standing <= v.returns;
  }

  [[nodiscard]] Eigen::AlignedBox3d around(const std::set<BodyCell>& reached) const {
    std::array<std::vector<double>, 3> at;
    for (const BodyReturn& r : returns_) {
      if (!reached.contains(cell_of(r.p_body))) continue;
      for (std::size_t axis = 0; axis < 3; ++axis)
        at[axis].push_back(r.p_body(static_cast<Eigen::Index>(axis)));
    }
    Eigen::AlignedBox3d box;
    if (at[0].empty()) return box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::sort(at[axis].begin(), at[axis].end());
      const auto stray = static_cast<std::size_t>(kStray * static_cast<double>(at[axis].size()));
      box.min()(static_cast<Eigen::Index>(axis)) = at[axis][stray];
      box.max()(static_cast<Eigen::Index>(axis)) = at[axis][at[axis].size() - 1 - stray];
    }
    box.min().z() = 0.0;
    return box;
  }

  const BodyTrack& track_;
  std::vector<BodyReturn> returns_;
  std::map<BodyCell, Voxel> voxels_;
};

}  // namespace

void grow_in_space(const SweepSeries& series,
                   BodyTrack& track,
                   const std::vector<std::vector<Motion>>& motion,
                   const TakenReturns& taken) {
  for (int round = 0; round < kGrowthRounds; ++round) {
    const Eigen::AlignedBox3d box = Growth(series, track, motion, taken).box();
    if (box.isEmpty()) return;
    const Vector3d grown = box.sizes() - track.box.sizes();
    track.box = box;
    if (grown.maxCoeff() < kGrown_m) return;
  }
}

}  // namespace simuli
