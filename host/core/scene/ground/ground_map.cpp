#include "host/core/scene/ground/ground_map.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "host/core/base/spread.hpp"
#include "host/core/scene/edit.hpp"

namespace simuli {

GroundMap::Cell GroundMap::cell_of(double x, double y) {
  return {static_cast<int>(std::floor(x / kCell_m)), static_cast<int>(std::floor(y / kCell_m))};
}

void GroundMap::add(const Eigen::Matrix3Xf& points) {
  std::map<Cell, std::vector<float>> heights;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f p = points.col(i);
    heights[cell_of(p.x(), p.y())].push_back(p.z());
  }
  for (auto& [cell, z] : heights) {
    const auto low = z.begin() + static_cast<std::ptrdiff_t>(kLow * static_cast<double>(z.size()));
    std::nth_element(z.begin(), low, z.end());
    lows_[cell].push_back({*low, static_cast<std::uint32_t>(z.size())});
  }
}

/// Lower quartile of the sweeps' heights of each cell, weighted by their returns.
std::map<GroundMap::Cell, float> GroundMap::lows() {
  std::map<Cell, float> out;
  for (auto& [cell, of_sweeps] : lows_) {
    std::sort(of_sweeps.begin(), of_sweeps.end(), [](const Low& a, const Low& b) { return a.z < b.z; });
    std::size_t all = 0, below = 0;
    for (const Low& low : of_sweeps) all += low.returns;
    for (const Low& low : of_sweeps) {
      out[cell] = low.z;
      below += low.returns;
      if (4 * below >= all) break;
    }
  }
  lows_.clear();
  return out;
}

std::map<GroundMap::Cell, float> GroundMap::without_pits(const std::map<Cell, float>& lows) {
  std::map<Cell, float> out;
  for (const auto& [cell, z] : lows) {
    std::vector<float> around;
    for (int k = 0; k < 25; ++k) {
      const auto other = lows.find({cell[0] + k % 5 - 2, cell[1] + k / 5 - 2});
      if (other != lows.end()) around.push_back(other->second);
    }
    out[cell] = std::max(z, upper_median(std::move(around)) - static_cast<float>(kPit_m));
  }
  return out;
}

void GroundMap::finish() {
  const std::map<Cell, float> low = without_pits(lows());
  height_.clear();
  for (const auto& [cell, z] : low) {
    double height = z;
    for (int dx = -kReachCells; dx <= kReachCells; ++dx) {
      for (int dy = -kReachCells; dy <= kReachCells; ++dy) {
        const auto other = low.find({cell[0] + dx, cell[1] + dy});
        if (other == low.end()) continue;
        height = std::min(height, other->second + kSlope * kCell_m * std::hypot(dx, dy));
      }
    }
    height_[cell] = static_cast<float>(height);
  }
}

std::optional<double> GroundMap::height_m(double x, double y) const {
  const Cell first = cell_of(x - 0.5 * kCell_m, y - 0.5 * kCell_m);
  const double u = x / kCell_m - 0.5 - first[0], v = y / kCell_m - 0.5 - first[1];
  double sum = 0.0, weight = 0.0;
  for (int k = 0; k < 4; ++k) {
    const auto at = height_.find({first[0] + k % 2, first[1] + k / 2});
    if (at == height_.end()) continue;
    const double w = (k % 2 == 1 ? u : 1.0 - u) * (k / 2 == 1 ? v : 1.0 - v) + 1e-9;
    sum += w * at->second;
    weight += w;
  }
  if (weight == 0.0) return std::nullopt;
  return sum / weight;
}

/// Fills cells without height, but with heights in most of their eight neighbours, with the mean of these;
/// repeated a few times.
std::map<GroundMap::Cell, float> GroundMap::closed(std::map<Cell, float> heights) {
  constexpr int kTimes = 3, kMost = 5;
  for (int time = 0; time < kTimes; ++time) {
    std::map<Cell, std::pair<float, int>> around;  // sum, count
    for (const auto& [cell, z] : heights) {
      for (int k = 0; k < 9; ++k) {
        const Cell other{cell[0] + k % 3 - 1, cell[1] + k / 3 - 1};
        if (heights.contains(other)) continue;
        auto& [sum, count] = around[other];
        sum += z;
        ++count;
      }
    }
    for (const auto& [cell, sum] : around) {
      if (sum.second >= kMost) heights[cell] = sum.first / static_cast<float>(sum.second);
    }
  }
  return heights;
}

TriangleMesh GroundMap::mesh(const std::vector<Eigen::Vector2d>& places) const {
  const std::map<Cell, float> heights = closed(height_);
  std::set<Cell> reached;
  std::vector<Cell> open;
  const auto reach = [&](const Cell& cell) {
    if (heights.contains(cell) && reached.insert(cell).second) open.push_back(cell);
  };
  const auto reach_around = [&](const Cell& cell) {
    for (int k = 0; k < 9; ++k) reach({cell[0] + k % 3 - 1, cell[1] + k / 3 - 1});
  };
  for (const Eigen::Vector2d& place : places) reach_around(cell_of(place.x(), place.y()));
  while (!open.empty()) {
    const Cell cell = open.back();
    open.pop_back();
    reach_around(cell);
  }
  TriangleMesh mesh;
  std::map<Cell, std::uint32_t> vertex;
  for (const Cell& cell : reached) {
    vertex[cell] = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(static_cast<float>((cell[0] + 0.5) * kCell_m),
                               static_cast<float>((cell[1] + 0.5) * kCell_m),
                               heights.at(cell));
  }
  for (const auto& [cell, first] : vertex) {
    const auto along = vertex.find({cell[0] + 1, cell[1]}), across = vertex.find({cell[0], cell[1] + 1});
    const auto beyond = vertex.find({cell[0] + 1, cell[1] + 1});
    if (along == vertex.end() || across == vertex.end() || beyond == vertex.end()) continue;
    mesh.triangles.push_back({first, along->second, beyond->second});
    mesh.triangles.push_back({first, beyond->second, across->second});
  }
  return mesh;
}

GroundMap ground_of(const Scene& scene) {
  const GaussianSet still = background_of(scene, SetKind::kLidar);
  Eigen::Matrix3Xf solid(3, still.size());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < still.size(); ++i) {
    if (still.opacity_logit()(i) >= 0.0F) solid.col(count++) = still.mean().row(i).transpose();
  }
  GroundMap map;
  map.add(solid.leftCols(count));
  map.finish();
  return map;
}

TriangleMesh ground_mesh(const GroundMap& ground, const Scene& scene, const Trajectory& world_from_rig) {
  std::vector<Eigen::Vector2d> below;
  for (const TimedPose& pose : world_from_rig.poses()) {
    below.emplace_back((pose.pose.translation - scene.origin).head<2>());
  }
  return ground.mesh(below);
}

}  // namespace simuli
