#include "optim/actors/find_actors.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "host/core/base/fields.hpp"
#include "optim/actors/body_track.hpp"
#include "optim/actors/motion_evidence.hpp"
#include "optim/actors/moving_clusters.hpp"
#include "optim/actors/sweep_series.hpp"

namespace simuli {
namespace {

constexpr double kTakenShare = 0.5;  // share of a chain inside a body found before, from which it is skipped
constexpr double kGrownBox_m = 0.3;  // growth of a box that justifies another iteration
constexpr double kBodyMargin_m = 0.2;  // margin around a box that belongs to the body
constexpr std::size_t kSweepsOfAVote = 24;
constexpr double kMostThroughABody = 0.12;  // share of see-through votes on a body along its track
constexpr double kLeastMovingShare = 0.1;  // share of its returns
constexpr double kLeastReturnsOfABody = 15.0;  // per sweep
constexpr double kTopRows_rad = 0.012;  // below the highest row: about two rows
constexpr double kVehicle_m = 4.0;  // legal height of vehicles
const Eigen::Vector3d kLeastSize_m(0.5, 0.3, 0.8);

/// State of one search.
class Search {
 public:
  Search(const Log& log, const FrameSelection& frames, const ActorFinding& options)
      : log_(log), rule_(log, frames), options_(options), series_(load_series(log, rule_)) {
    for (const SeriesSweep& sweep : series_.sweeps) taken_.emplace_back(sweep.points.size(), false);
  }

  [[nodiscard]] FoundActors run() && {
    out_.report.sweeps = series_.sweeps.size();
    if (series_.sweeps.size() < static_cast<std::size_t>(options_.min_sweeps)) return std::move(out_);
    motion_ = motion_evidence(series_);
    for (const std::vector<Motion>& of_sweep : motion_)
      out_.report.moving_returns +=
          static_cast<std::size_t>(std::count(of_sweep.begin(), of_sweep.end(), Motion::kMoves));
    for (const Actor& label : log_.actors) judge(label);
    std::vector<std::vector<MovingCluster>> clusters = moving_clusters(series_, motion_);
    find_velocities(series_, clusters);
    const std::vector<ClusterChain> chains = chains_of(series_, clusters);
    out_.report.chains = chains.size();
    for (const ClusterChain& chain : chains) follow(chain);
    std::stable_sort(out_.actors.begin(), out_.actors.end(), [](const Actor& a, const Actor& b) {
      return a.track.front().time_s < b.track.front().time_s;
    });
    for (std::size_t i = 0; i < out_.actors.size(); ++i) out_.actors[i].name = fmt::format("moving_{}", i);
    out_.report.actors = out_.actors.size();
    return std::move(out_);
  }

 private:
  void follow(const ClusterChain& chain);
  [[nodiscard]] bool is_taken(const ClusterChain& chain) const;
  /// Returns the share of see-through votes on a body along its track, if enough sweeps and returns vote and
  /// enough returns moved (`moves`) or did not (!`moves`); no value otherwise.
  [[nodiscard]] std::optional<double> seen_through(const BodyTrack& track, bool moves) const;
  void judge(const Actor& label);
  [[nodiscard]] bool is_body(const BodyTrack& track) const;
  [[nodiscard]] bool is_cut_above(const BodyTrack& track) const;
  void take(const BodyTrack& track);
  [[nodiscard]] Actor finished(BodyTrack track) const;

  const Log& log_;
  HeldOutRule rule_;
  const ActorFinding& options_;
  SweepSeries series_;
  std::vector<std::vector<Motion>> motion_;
  TakenReturns taken_;
  FoundActors out_;
};

bool Search::is_taken(const ClusterChain& chain) const {
  std::size_t all = 0, taken = 0;
  for (const MovingCluster* cluster : chain) {
    for (const std::uint32_t i : cluster->points) {
      ++all;
      taken += taken_[cluster->sweep][i] ? 1U : 0U;
    }
  }
  return static_cast<double>(taken) >= kTakenShare * static_cast<double>(all);
}

void Search::follow(const ClusterChain& chain) {
  if (is_taken(chain)) return;
  BodyTrack track = track_of(series_, chain);
  align(series_, track, taken_);
  grow_in_space(series_, track, motion_, taken_);
  align(series_, track, taken_);
  for (int round = 0; round < 2; ++round) {
    const std::size_t keys = track.keys();
    grow_in_time(series_, track, taken_);
    if (track.keys() > keys) align(series_, track, taken_);
    const Eigen::Vector3d size_m = track.box.sizes();
    grow_in_space(series_, track, motion_, taken_);
    if ((track.box.sizes() - size_m).maxCoeff() < kGrownBox_m) break;
    align(series_, track, taken_);
  }
  if (!is_body(track)) return;
  const bool is_cut = is_cut_above(track);
  take(track);
  if (is_cut) track.box.max().z() = std::max(track.box.max().z(), kVehicle_m);
  out_.actors.push_back(finished(std::move(track)));
}

std::optional<double> Search::seen_through(const BodyTrack& track, bool moves) const {
  if (track.keys() < static_cast<std::size_t>(options_.min_sweeps)) return std::nullopt;
  const std::vector<BodyReturn> returns = all_returns(series_, track, track.box, taken_);
  const auto count = static_cast<double>(returns.size());
  if (count < kLeastReturnsOfABody * static_cast<double>(track.keys())) return std::nullopt;
  std::size_t moving = 0;
  PointSet points;
  points.position.resize(3, static_cast<Eigen::Index>(returns.size()));
  points.intensity.assign(returns.size(), 0.0F);
  for (std::size_t i = 0; i < returns.size(); ++i) {
    moving += motion_[track.sweeps[returns[i].key]][returns[i].point] == Motion::kMoves ? 1U : 0U;
    points.position.col(static_cast<Eigen::Index>(i)) = returns[i].p_body.cast<float>();
  }
  if ((static_cast<double>(moving) >= kLeastMovingShare * count) != moves) return std::nullopt;
  double through = 0.0, there = 0.0;
  for (const PointVotes& v : votes_along(series_, track, points, kSweepsOfAVote)) {
    through += v.through;
    there += v.there;
  }
  const double votes = through + there;
  return votes > 0.0 ? through / votes : 0.0;
}

bool Search::is_body(const BodyTrack& track) const {
  if (track.actor.travel_m() < kLeastFoundTravel_m) return false;
  if ((track.box.sizes().array() < kLeastSize_m.array()).any()) return false;
  const std::optional<double> through = seen_through(track, true);
  return through && *through <= kMostThroughABody;
}

void Search::judge(const Actor& label) {
  if (label.travel_m() < kLeastFoundTravel_m) return;
  BodyTrack track;
  track.box = Eigen::AlignedBox3d(-0.5 * label.size_m, 0.5 * label.size_m);
  for (std::size_t i = 0; i < series_.sweeps.size(); ++i) {
    const double time_s = series_.sweeps[i].middle_s();
    if (!label.is_there(time_s)) continue;
    track.sweeps.push_back(i);
    track.actor.track.push_back({time_s, label.at(time_s)});
    track.actor.track.back().world_from_actor.translation -= series_.scene_origin;
  }
  const std::optional<double> through = seen_through(track, false);
  if (through && *through > kMostThroughABody) out_.standing.push_back(label.name);
}

/// Whether the body always extended above the LiDAR's field of view.
bool Search::is_cut_above(const BodyTrack& track) const {
  constexpr std::size_t kLeast = 30, kHigh = 3;
  const LidarRow& top = series_.lidar.rows.front();
  for (std::size_t k = 0; k < track.keys(); ++k) {
    const SeriesSweep& sweep = series_.sweeps[track.sweeps[k]];
    const std::vector<BodyReturn> returns = returns_of(series_, track, k, track.box, taken_);
    std::size_t high = 0;
    for (const BodyReturn& r : returns) {
      const Pose scene_from_lidar =
          interpolate(sweep.scene_from_lidar_start, sweep.scene_from_lidar_end, sweep.time_fraction[r.point]);
      const Eigen::Vector3d p = scene_from_lidar.inverse() * sweep.position(r.point);
      const double elevation = std::atan2(p.z() - top.vertical_offset, p.head<2>().norm());
      high += elevation > top.elevation - kTopRows_rad ? 1U : 0U;
    }
    if (returns.size() >= kLeast && high < kHigh) return false;
  }
  return true;
}

void Search::take(const BodyTrack& track) {
  Eigen::AlignedBox3d box = track.box;
  box.min() -= Eigen::Vector3d(kBodyMargin_m, kBodyMargin_m, 0.0);
  box.max() += Eigen::Vector3d::Constant(kBodyMargin_m);
  for (const BodyReturn& r : all_returns(series_, track, box, taken_)) {
    const std::size_t sweep = track.sweeps[r.key];
    taken_[sweep][r.point] = true;
    ++out_.report.returns_on_actors;
    out_.report.moving_on_actors += motion_[sweep][r.point] == Motion::kMoves ? 1U : 0U;
  }
}

/// Returns the actor in the world, centred in its box, extended over held-out sweeps at its ends.
Actor Search::finished(BodyTrack track) const {
  Actor out = std::move(track.actor);
  out.kind = "moving";
  out.size_m = track.box.sizes();
  const Pose body_from_centre{Eigen::Quaterniond::Identity(), track.box.center()};
  for (KeyPose& key : out.track) {
    key.world_from_actor = key.world_from_actor * body_from_centre;
    key.world_from_actor.translation += series_.scene_origin;
  }
  const auto add_end = [&](const SweepFrame& frame, const Actor& actor) {
    KeyPose key;
    key.time_s = 0.5 * (frame.time_start_s + frame.time_end_s);
    key.world_from_actor = actor.at(key.time_s);
    return key;
  };
  const Actor seen = out;
  const double first_s = seen.track.front().time_s, last_s = seen.track.back().time_s;
  for (std::size_t i = 0; i < log_.sweeps.size(); ++i) {
    const SweepFrame& frame = log_.sweeps[i];
    if (rule_.use(i, frame) != FrameUse::kBetween || frame.lidar != series_.lidar.name) continue;
    const double middle_s = 0.5 * (frame.time_start_s + frame.time_end_s);
    const double period_s = frame.time_end_s - frame.time_start_s;
    if (middle_s < first_s && first_s - middle_s < 1.5 * period_s)
      out.track.insert(out.track.begin(), add_end(frame, seen));
    if (middle_s > last_s && middle_s - last_s < 1.5 * period_s) out.track.push_back(add_end(frame, seen));
  }
  return out;
}

}  // namespace

FoundActors find_actors(const Log& log, const FrameSelection& frames, const ActorFinding& options) {
  check_fields(frames);
  check_fields(options);
  const auto begin = std::chrono::steady_clock::now();
  FoundActors out = Search(log, frames, options).run();
  out.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace simuli
