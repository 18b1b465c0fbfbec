#include "optim/actors/body_track.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/core/base/parallel.hpp"
#include "host/core/base/spread.hpp"
#include "optim/init/actor_tracks.hpp"

namespace simuli {
namespace {

constexpr std::size_t kMostReturns = 8'000;  // that a track is aligned to
constexpr double kHeading_m = 1.5;           // shortest path that determines a heading
constexpr double kBoxMargin_m = 0.15;
/// The initial track comes from velocities of single sweeps.
constexpr TrackPrior kPrior{
    .label_m = 0.5, .label_rad = 0.1, .acceleration_m_per_s2 = 3.0, .turn_rad_per_s2 = 0.5};

double ground_m(const SweepSeries& series, const Eigen::Vector3d& p) {
  return series.ground.height_m(p.x(), p.y()).value_or(p.z());
}

/// Heading of each key from the path around it; for standing keys the heading of the nearest moving one.
std::vector<double> headings_of(const std::vector<KeyPose>& track) {
  std::vector<double> out(track.size(), 0.0);
  std::vector<bool> known(track.size(), false);
  for (std::size_t k = 0; k < track.size(); ++k) {
    std::size_t first = k, last = k;
    Eigen::Vector3d way = Eigen::Vector3d::Zero();
    while (way.head<2>().norm() < kHeading_m && (first > 0 || last + 1 < track.size())) {
      if (first > 0) --first;
      if (last + 1 < track.size()) ++last;
      way = track[last].corrected().translation - track[first].corrected().translation;
      if (last - first > 8) break;
    }
    if (way.head<2>().norm() < kHeading_m) continue;
    out[k] = std::atan2(way.y(), way.x());
    known[k] = true;
  }
  for (std::size_t k = 0; k < track.size(); ++k) {
    if (known[k]) continue;
    std::size_t best = track.size();
    for (std::size_t other = 0; other < track.size(); ++other) {
      if (!known[other]) continue;
      const auto apart = [&](std::size_t i) { return std::abs(track[i].time_s - track[k].time_s); };
      if (best == track.size() || apart(other) < apart(best)) best = other;
    }
    if (best < track.size()) {
      out[k] = out[best];
    } else if (track.size() > 1) {
      const Eigen::Vector3d way =
          track.back().corrected().translation - track.front().corrected().translation;
      out[k] = std::atan2(way.y(), way.x());
    }
  }
  return out;
}

Eigen::Quaterniond turn_about_z(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
}

double yaw_of(const Eigen::Quaterniond& q) {
  const Eigen::Vector3d x = q * Eigen::Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

/// Rotates the body's frame so that x is the median driving direction of the moving keys.
void face_forward(BodyTrack& track) {
  const std::vector<double> headings = headings_of(track.actor.track);
  std::vector<double> off;
  for (std::size_t k = 0; k < headings.size(); ++k) {
    const double apart = headings[k] - yaw_of(track.actor.track[k].world_from_actor.rotation);
    off.push_back(std::remainder(apart, 2.0 * M_PI));
  }
  const double off_rad = upper_median(std::move(off));
  const Eigen::Quaterniond turn = turn_about_z(off_rad);
  for (KeyPose& key : track.actor.track) {
    key.world_from_actor.rotation = (key.world_from_actor.rotation * turn).normalized();
  }
  Eigen::AlignedBox3d box;
  for (int k = 0; k < 8; ++k) {
    box.extend(turn.conjugate() * track.box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k)));
  }
  // A small rotation would enlarge a long box: its sides stay unchanged.
  if (std::abs(off_rad) > 0.2) track.box = box;
}

}  // namespace

BodyTrack track_of(const SweepSeries& series, const ClusterChain& chain) {
  BodyTrack out;
  Eigen::Vector3d position = chain.front()->mean;
  for (std::size_t k = 0; k < chain.size(); ++k) {
    const MovingCluster& c = *chain[k];
    if (k > 0) {
      const MovingCluster& last = *chain[k - 1];
      position.head<2>() += 0.5 * (c.time_s - last.time_s) * (c.velocity_m_per_s + last.velocity_m_per_s);
    }
    position.z() = ground_m(series, position);
    out.sweeps.push_back(c.sweep);
    KeyPose& key = out.actor.track.emplace_back();
    key.time_s = c.time_s;
    key.world_from_actor.translation = position;
  }
  const std::vector<double> headings = headings_of(out.actor.track);
  for (std::size_t k = 0; k < chain.size(); ++k) {
    out.actor.track[k].world_from_actor.rotation = turn_about_z(headings[k]);
  }
  for (std::size_t k = 0; k < chain.size(); ++k) {
    const SeriesSweep& sweep = series.sweeps[chain[k]->sweep];
    for (const std::uint32_t i : chain[k]->points) {
      out.box.extend(out.actor.at(sweep.time_s(i)).inverse() * sweep.position(i));
    }
  }
  out.box.min().z() = 0.0;
  return out;
}

std::vector<BodyReturn> returns_of(const SweepSeries& series,
                                   const BodyTrack& track,
                                   std::size_t key,
                                   const Eigen::AlignedBox3d& box,
                                   const TakenReturns& taken) {
  std::vector<BodyReturn> out;
  const SeriesSweep& sweep = series.sweeps[track.sweeps[key]];
  const Pose here = track.actor.track[key].corrected();
  const double reach_m = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm() + 5.0;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    if (taken[track.sweeps[key]][i]) continue;
    const Eigen::Vector3d p = sweep.position(i);
    if ((p - here.translation).squaredNorm() > reach_m * reach_m) continue;
    const double time_s = sweep.time_s(i);
    const Eigen::Vector3d p_body = track.actor.at(time_s).inverse() * p;
    if (!box.contains(p_body)) continue;
    out.push_back({key, static_cast<std::uint32_t>(i), time_s, p_body});
  }
  return out;
}

std::vector<BodyReturn> all_returns(const SweepSeries& series,
                                    const BodyTrack& track,
                                    const Eigen::AlignedBox3d& box,
                                    const TakenReturns& taken) {
  std::vector<std::vector<BodyReturn>> of_keys(track.keys());
  parallel_each(
      of_keys.size(), [&](std::size_t k) { of_keys[k] = returns_of(series, track, k, box, taken); }, 1);
  std::vector<BodyReturn> out;
  for (const std::vector<BodyReturn>& here : of_keys) out.insert(out.end(), here.begin(), here.end());
  return out;
}

void align(const SweepSeries& series, BodyTrack& track, const TakenReturns& taken) {
  Eigen::AlignedBox3d box = track.box;
  box.min() -= Eigen::Vector3d(kBoxMargin_m, kBoxMargin_m, 0.0);
  box.max() += Eigen::Vector3d::Constant(kBoxMargin_m);
  const std::vector<BodyReturn> inside = all_returns(series, track, box, taken);
  const std::size_t step = inside.size() / kMostReturns + 1;
  std::vector<ActorReturn> returns;
  for (std::size_t i = 0; i < inside.size(); i += step) {
    const BodyReturn& r = inside[i];
    returns.push_back({r.time_s, series.sweeps[track.sweeps[r.key]].position(r.point)});
  }
  register_track(track.actor, returns, kPrior);
  for (KeyPose& key : track.actor.track) {
    key.world_from_actor = key.corrected();
    key.shift_m = key.turn_rad = Eigen::Vector3d::Zero();
  }
  face_forward(track);
}

std::vector<PointVotes> votes_along(const SweepSeries& series,
                                    const BodyTrack& track,
                                    const PointSet& p_body,
                                    std::size_t sweeps) {
  std::vector<double> way{0.0};  // plus a little per second, so that standing times are sampled, too
  constexpr double kStanding_m_per_s = 0.5;
  for (std::size_t k = 1; k < track.keys(); ++k) {
    const KeyPose &a = track.actor.track[k - 1], &b = track.actor.track[k];
    way.push_back(way.back() + (b.world_from_actor.translation - a.world_from_actor.translation).norm() +
                  kStanding_m_per_s * (b.time_s - a.time_s));
  }
  std::vector<PointVotes> votes(p_body.size());
  std::size_t requested = track.keys();
  for (std::size_t n = 0; n < sweeps; ++n) {
    const double at = way.back() * (static_cast<double>(n) + 0.5) / static_cast<double>(sweeps);
    const auto key = static_cast<std::size_t>(std::lower_bound(way.begin(), way.end(), at) - way.begin());
    if (key == requested || key >= track.keys()) continue;
    requested = key;
    const Pose pose = track.actor.track[key].corrected();
    PointSet placed = p_body;
    // A long object is swept during a good part of the revolution, and moves meanwhile.
    parallel_each(placed.size(), [&](std::size_t i) {
      const auto column = static_cast<Eigen::Index>(i);
      const Eigen::Vector3d p = p_body.position.col(column).cast<double>();
      const double time_s = series.looks_at_s(track.sweeps[key], pose * p);
      placed.position.col(column) = (track.actor.at(time_s) * p).cast<float>();
    });
    series.vote(track.sweeps[key], placed, votes);
  }
  return votes;
}

}  // namespace simuli
