#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "host/core/base/parallel.hpp"
#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"
#include "optim/base/metrics.hpp"
#include "optim/data/sensor_learning.hpp"
#include "optim/init/points/point_tree.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {
namespace {

constexpr std::size_t kFewestSweeps = 8;
constexpr int kRounds = 3;
constexpr double kVoxel_m = 0.1;
constexpr float kNearest_m = 2.0F;
constexpr float kFarthest_m = 50.0F;
constexpr std::size_t kMapStep = 3;     // every so many rays of a row enter the map
constexpr std::size_t kSampleStep = 8;  // of these, every so many are compared with the map
constexpr std::size_t kNeighbours = 24;
constexpr float kReach_m = 0.6F;  // to the farthest neighbour
/// Limits for planes through neighbours: standard deviation off the plane, and relative to the smaller one
/// along it.
constexpr double kFlat_m = 0.04;
constexpr double kFlatShare = 0.25;
constexpr double kLineShare = 0.15;  // smallest ratio of the standard deviations along the plane
constexpr double kRimShare = 0.6;  // largest distance from the neighbours' centre relative to the smaller one
constexpr double kHuber_m = 0.03;
constexpr double kOutlier_m = 0.15;
constexpr double kCounts_m = 0.005;
constexpr double kCountsSigmas = 5.0;
/// Azimuth sectors with separate estimates: errors by the street (edges, curved walls) differ between sectors,
/// a bias does not.
constexpr std::size_t kGroups = 8;
constexpr std::size_t kFewestGroups = 4;
constexpr double kFewestEquations = 1.0;  // per sector, at normal incidence

/// A return in the scene.
struct Hit {
  Eigen::Vector3f origin, direction;
  float range = 0.0F;
  std::uint16_t row = 0, group = 0;

  [[nodiscard]] Eigen::Vector3f at(double bias_m) const {
    return origin + (range - static_cast<float>(bias_m)) * direction;
  }
};

std::uint16_t sector_of(double azimuth) {
  const double turns = azimuth / (2.0 * std::numbers::pi);
  return static_cast<std::uint16_t>(
      std::min(static_cast<std::size_t>((turns - std::floor(turns)) * kGroups), kGroups - 1));
}

std::vector<Hit> hits_of(const Log& log, const LogLidar& mounted, const std::vector<std::size_t>& sweeps) {
  const Lidar& lidar = mounted.with_rows();
  const Eigen::Vector3d origin = log.world_from_rig.at(log.sweeps[sweeps.front()].time_start_s).translation;
  std::vector<Hit> hits;
  for (std::size_t s = 0; s < sweeps.size(); ++s) {
    const SweepFrame& frame = log.sweeps[sweeps[s]];
    const Sweep sweep = read_sweep(log, frame, lidar);
    Pose start = log.world_from_rig.at(frame.time_start_s) * mounted.rig_from_lidar;
    Pose end = log.world_from_rig.at(frame.time_end_s) * mounted.rig_from_lidar;
    start.translation -= origin;
    end.translation -= origin;
    const auto columns = static_cast<std::size_t>(lidar.columns);
    for (std::size_t i = s % kMapStep; i < sweep.range.size(); i += kMapStep) {
      if (!(sweep.range[i] >= kNearest_m && sweep.range[i] <= kFarthest_m)) continue;
      const double azimuth = sweep.rays.azimuth[i];
      const std::size_t row = i / columns;
      const Pose scene_from_lidar = interpolate(start, end, sweep.rays.time_fraction[i]);
      const Eigen::Vector3d direction =
          scene_from_lidar.rotation * Lidar::direction(azimuth, sweep.rays.elevation[i]);
      hits.push_back({(scene_from_lidar * lidar.origin(static_cast<int>(row), azimuth)).cast<float>(),
                      direction.cast<float>(),
                      sweep.range[i],
                      static_cast<std::uint16_t>(row),
                      sector_of(azimuth)});
    }
  }
  return hits;
}

/// Equation of a hit: (n . d) bias = n . (hit - plane).
struct Equation {
  double along = 0.0;  // n . d; 0: no plane
  double off_m = 0.0;
};

Equation equation_of(const PointSet& points, const PointTree& tree, const Hit& hit, double bias_m) {
  const Eigen::Vector3f p = hit.at(bias_m);
  std::array<std::uint32_t, kNeighbours> near{};
  std::array<float, kNeighbours> distance2{};
  const std::size_t found = tree.knnSearch(p.data(), kNeighbours, near.data(), distance2.data());
  if (found < kNeighbours || distance2.back() > kReach_m * kReach_m) return {};
  Eigen::Matrix<float, 3, kNeighbours> cloud;
  for (std::size_t k = 0; k < kNeighbours; ++k)
    cloud.col(static_cast<Eigen::Index>(k)) = points.position.col(near[k]);
  const Eigen::Vector3f mean = cloud.rowwise().mean();
  const Eigen::Matrix<double, 3, kNeighbours> centred = (cloud.colwise() - mean).cast<double>();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(centred * centred.transpose() / static_cast<double>(kNeighbours));
  const Eigen::Vector3d deviation = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();  // ascending
  if (deviation(0) > kFlat_m || deviation(0) > kFlatShare * deviation(1) ||
      deviation(1) < kLineShare * deviation(2)) {
    return {};
  }
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  const Eigen::Vector3d from_mean = (p - mean).cast<double>();
  const double off_m = normal.dot(from_mean);
  // Neighbours at the edge of a surface are one-sided and biased.
  if ((from_mean - off_m * normal).norm() > kRimShare * deviation(1)) return {};
  if (std::abs(off_m) > kOutlier_m) return {};
  return {normal.dot(hit.direction.cast<double>()), off_m};
}

struct Sums {
  double along2 = 0.0, off = 0.0;
  [[nodiscard]] double value() const { return off / along2; }
};

}  // namespace

std::vector<RangeBias> find_range_bias(const Log& log, const LogLidar& lidar, const FrameSelection& frames) {
  std::vector<std::size_t> sweeps;
  for (const std::size_t index : HeldOutRule(log, frames).training(log.sweeps)) {
    if (log.sweeps[index].lidar == name_of(lidar.model)) sweeps.push_back(index);
  }
  if (sweeps.size() < kFewestSweeps) return {};
  const std::vector<Hit> hits = hits_of(log, lidar, sweeps);
  const std::size_t rows = lidar.with_rows().rows.size();
  std::vector<RangeBias> biases(rows);
  std::vector<Equation> equations(hits.size() / kSampleStep);
  for (int round = 0; round < kRounds; ++round) {
    VoxelGrid grid(kVoxel_m);
    for (const Hit& hit : hits) grid.add(hit.at(biases[hit.row].bias_m).cast<double>(), 0.0);
    const PointSet points = grid.averages();
    const CloudView cloud{points};
    PointTree tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16));
    tree.buildIndex();
    parallel_each(equations.size(), [&](std::size_t i) {
      const Hit& hit = hits[i * kSampleStep];
      equations[i] = equation_of(points, tree, hit, biases[hit.row].bias_m);
    });
    std::vector<std::array<Sums, kGroups>> sums(rows);
    for (std::size_t i = 0; i < equations.size(); ++i) {
      const Hit& hit = hits[i * kSampleStep];
      const Equation& e = equations[i];
      const double weight = std::min(1.0, kHuber_m / std::max(std::abs(e.off_m), 1e-9));
      Sums& s = sums[hit.row][hit.group];
      s.along2 += weight * e.along * e.along;
      s.off += weight * e.along * e.off_m;
    }
    std::vector<double> known;
    for (std::size_t row = 0; row < rows; ++row) {
      Sums all;
      std::size_t reported = 0;
      for (const Sums& sum : sums[row]) {
        if (sum.along2 < kFewestEquations) continue;
        all.along2 += sum.along2;
        all.off += sum.off;
        ++reported;
      }
      RangeBias& b = biases[row];
      b.sigma_m = std::numeric_limits<double>::infinity();
      if (reported < kFewestGroups) continue;
      double square = 0.0;
      for (const Sums& sum : sums[row]) {
        if (sum.along2 < kFewestEquations) continue;
        const double off = sum.along2 / all.along2 * (sum.value() - all.value());
        square += off * off;
      }
      b.sigma_m = std::sqrt(square * static_cast<double>(reported) / static_cast<double>(reported - 1));
      b.bias_m += all.value();
      known.push_back(b.bias_m);
    }
    if (known.empty()) return {};
    const double middle = median(std::move(known));
    for (RangeBias& b : biases) b.bias_m = std::isfinite(b.sigma_m) ? b.bias_m - middle : 0.0;
  }
  return biases;
}

Log with_range_bias(Log log, const FrameSelection& frames) {
  for (std::size_t i = 0; i < log.lidars.size(); ++i) {
    auto* const lidar = std::get_if<Lidar>(&log.lidars[i].model);
    if (lidar == nullptr) continue;  // biases belong to rows
    std::vector<LidarRow>& rows = lidar->rows;
    if (std::any_of(rows.begin(), rows.end(), [](const LidarRow& row) { return row.range_bias != 0.0; }))
      continue;
    const std::vector<RangeBias> found = find_range_bias(log, log.lidars[i], frames);
    for (std::size_t row = 0; row < found.size(); ++row) {
      const double size_m = std::abs(found[row].bias_m);
      if (size_m > kCounts_m && size_m > kCountsSigmas * found[row].sigma_m)
        rows[row].range_bias = found[row].bias_m;
    }
  }
  return log;
}

}  // namespace simuli
