#include "optim/actors/sweep_series.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_set>
#include <variant>

#include "io/log/frame_files.hpp"
#include "optim/init/posed_frames.hpp"

namespace simuli {
namespace {

constexpr double kFarthest_m = 70.0;
constexpr double kLowest_m = 0.3;  // above the ground; lower rays hit the road

const Lidar* finest_lidar(const Log& log) {
  const Lidar* finest = nullptr;
  for (const LogLidar& mounted : log.lidars) {
    const auto* const lidar = std::get_if<Lidar>(&mounted.model);
    if (lidar == nullptr) continue;
    if (finest == nullptr || lidar->ray_count() > finest->ray_count()) finest = lidar;
  }
  return finest;
}

std::uint64_t voxel_of(const Eigen::Vector3d& p) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto index = static_cast<std::int64_t>(std::floor(p(axis) / SeriesSweep::kThin_m)) + (1 << 20);
    key = key << 21U | (static_cast<std::uint64_t>(index) & 0x1fffffU);
  }
  return key;
}

/// Keeps the first return of each voxel.
void take_returns(const PosedSweep& posed, SeriesSweep& out) {
  std::unordered_set<std::uint64_t> taken;
  std::vector<Eigen::Vector3f> kept;
  const Sweep& sweep = posed.sweep;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (!(sweep.range[i] > 0.0F) || static_cast<double>(sweep.range[i]) > kFarthest_m) continue;
    const Pose scene_from_lidar =
        interpolate(posed.scene_from_lidar_start, posed.scene_from_lidar_end, sweep.rays.time_fraction[i]);
    const Eigen::Vector3d p =
        scene_from_lidar *
        Eigen::Vector3d(ray_origin(posed.lidar, sweep.rays, i) +
                        static_cast<double>(sweep.range[i]) *
                            Lidar::direction(sweep.rays.azimuth[i], sweep.rays.elevation[i]));
    if (!taken.insert(voxel_of(p)).second) continue;
    kept.emplace_back(p.cast<float>());
    out.points.intensity.push_back(sweep.intensity[i]);
    out.time_fraction.push_back(sweep.rays.time_fraction[i]);
  }
  out.points.position.resize(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i) {
    out.points.position.col(static_cast<Eigen::Index>(i)) = kept[i];
  }
}

void keep_above_ground(const GroundMap& ground, SeriesSweep& sweep) {
  std::vector<std::uint32_t> kept;
  std::vector<float> fractions;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const Eigen::Vector3d p = sweep.position(i);
    const std::optional<double> ground_m = ground.height_m(p.x(), p.y());
    if (!ground_m || p.z() < *ground_m + kLowest_m || p.z() > *ground_m + kHighest_m) continue;
    kept.push_back(static_cast<std::uint32_t>(i));
    fractions.push_back(sweep.time_fraction[i]);
  }
  sweep.points = sweep.points.subset(kept);
  sweep.time_fraction = std::move(fractions);
}

}  // namespace

void SweepSeries::vote(std::size_t index, const PointSet& points, std::vector<PointVotes>& votes) const {
  const SeriesSweep& s = sweeps[index];
  vote_on_points(s.seen, lidar, s.scene_from_lidar_start, s.scene_from_lidar_end, points, votes);
}

double SweepSeries::looks_at_s(std::size_t index, const Eigen::Vector3d& p_scene) const {
  const SeriesSweep& s = sweeps[index];
  double fraction = 0.5;
  for (int round = 0; round < 2; ++round) {
    const Pose scene_from_lidar = interpolate(s.scene_from_lidar_start, s.scene_from_lidar_end, fraction);
    const Eigen::Vector3d p = scene_from_lidar.inverse() * p_scene;
    double turn = lidar.spin_sign() * (std::atan2(p.y(), p.x()) - lidar.azimuth_first) / lidar.azimuth_span;
    const double whole = 2.0 * std::numbers::pi / lidar.azimuth_span;
    turn -= whole * std::floor(turn / whole);
    fraction = std::min(turn, 1.0);
  }
  return s.time_start_s + fraction * (s.time_end_s - s.time_start_s);
}

SweepSeries load_series(const Log& log, const HeldOutRule& rule) {
  SweepSeries series;
  series.scene_origin = scene_origin(log.world_from_rig);
  const Lidar* const lidar = finest_lidar(log);
  if (lidar == nullptr) return series;
  series.lidar = *lidar;
  std::vector<const SweepFrame*> frames = training_frames(log.sweeps, rule);
  std::erase_if(frames, [&](const SweepFrame* frame) { return frame->lidar != lidar->name; });
  expect(log, frames);
  for (const SweepFrame* frame : frames) {
    PosedSweep posed = load_sweep(log, *frame, series.scene_origin);
    SeriesSweep& sweep = series.sweeps.emplace_back();
    sweep.time_start_s = frame->time_start_s;
    sweep.time_end_s = frame->time_end_s;
    sweep.scene_from_lidar_start = posed.scene_from_lidar_start;
    sweep.scene_from_lidar_end = posed.scene_from_lidar_end;
    take_returns(posed, sweep);
    series.ground.add(sweep.points.position);
    sweep.seen.range = std::move(posed.sweep.range);
  }
  series.ground.finish();
  for (SeriesSweep& sweep : series.sweeps) keep_above_ground(series.ground, sweep);
  return series;
}

}  // namespace simuli
