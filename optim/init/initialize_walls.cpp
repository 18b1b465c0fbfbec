#include "optim/init/initialize_walls.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include "host/core/base/parallel.hpp"
#include "host/core/base/spread.hpp"
#include "optim/base/frames.hpp"
#include "optim/init/posed_frames.hpp"

namespace simuli {
namespace {

constexpr float kUpright = 0.25F;         // largest upward component of a normal
constexpr double kTopReach_m = 2.0;       // below the top, where a wall is detected
constexpr std::size_t kLeastPoints = 3;   // in that range
constexpr float kLeastHigh_m = 1.0F;      // smallest height of these points: tree crowns bend
constexpr float kOneWay = 0.7F;           // smallest length of the mean normal
constexpr double kHighest_m = 15.0;       // above the top
constexpr double kFarthestLook_m = 60.0;  // observations from farther away are ignored
constexpr double kWidest_m = 1.2;         // largest size of a pixel on the wall
constexpr std::size_t kMinObservations = 3;
constexpr float kAgreeing = 0.7F;     // share of the observations
constexpr int kAlikeOf255 = 15;       // largest difference per colour channel
constexpr float kEdge = 0.06F;        // smallest difference between neighbours
constexpr double kGap_m = 1.6;        // largest vertical gap without agreement
constexpr double kFinest_m = 0.1;     // spacing of tested positions
constexpr double kLeastAlong = 0.5;   // smallest share of a wall's columns present
constexpr double kOffPlane_m = 0.15;  // largest distance of columns to the plane
constexpr double kParallelWalls = 0.97;
constexpr double kStreak_m = 1.5;  // half length of a wall part with one height

float difference(const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// Returns for each column the columns of the same wall within kStreak_m, including itself.
std::vector<std::vector<std::size_t>> same_walls(const std::vector<WallColumn>& columns) {
  std::map<std::array<int, 2>, std::vector<std::size_t>> blocks;
  const auto block_of = [](const WallColumn& column) {
    const Eigen::Vector2i at = (column.position_m / kStreak_m).array().floor().cast<int>();
    return std::array<int, 2>{at.x(), at.y()};
  };
  for (std::size_t k = 0; k < columns.size(); ++k) blocks[block_of(columns[k])].push_back(k);
  std::vector<std::vector<std::size_t>> out(columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const std::array<int, 2> middle = block_of(columns[k]);
    for (int i = 0; i < 9; ++i) {
      const auto block = blocks.find({middle[0] + i % 3 - 1, middle[1] + i / 3 - 1});
      if (block == blocks.end()) continue;
      for (const std::size_t other : block->second) {
        const Eigen::Vector2d way = columns[other].position_m - columns[k].position_m;
        const bool is_same = way.norm() < kStreak_m && std::abs(way.dot(columns[k].normal)) < kOffPlane_m &&
                             std::abs(columns[other].normal.dot(columns[k].normal)) > kParallelWalls;
        if (is_same) out[k].push_back(other);
      }
    }
  }
  return out;
}

}  // namespace

double wall_cell_m(double voxel_m) { return std::max(2.0 * voxel_m, kFinest_m); }

std::vector<WallColumn> columns_of_walls(const std::vector<WallColumn>& columns, double cell_m) {
  const double least = kLeastAlong * 2.0 * kStreak_m / cell_m;
  const std::vector<std::vector<std::size_t>> same = same_walls(columns);
  std::vector<WallColumn> out;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (static_cast<double>(same[k].size()) >= least) out.push_back(columns[k]);
  }
  return out;
}

std::vector<double> heights_of_walls(const std::vector<WallColumn>& columns,
                                     const std::vector<double>& tops) {
  const std::vector<std::vector<std::size_t>> same = same_walls(columns);
  std::vector<double> out(columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    std::vector<double> around;
    for (const std::size_t other : same[k]) around.push_back(tops[other]);
    out[k] = upper_median(std::move(around));
  }
  return out;
}

std::vector<WallColumn> wall_columns(const PointSet& points, double cell_m) {
  struct Upright {
    Eigen::Vector3f p;
    Eigen::Vector2f normal;
    float intensity;
  };
  std::map<std::array<int, 2>, std::vector<Upright>> cells;
  const std::vector<LocalShape> shapes = local_shapes(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!shapes[i].planar) continue;
    const Eigen::Vector3f normal = shapes[i].scene_from_local * Eigen::Vector3f::UnitZ();
    if (!(std::abs(normal.z()) < kUpright)) continue;
    const Eigen::Vector3f p = points.position.col(static_cast<Eigen::Index>(i));
    const auto cell = [cell_m](float x) {
      return static_cast<int>(std::floor(static_cast<double>(x) / cell_m));
    };
    cells[{cell(p.x()), cell(p.y())}].push_back({p, normal.head<2>(), points.intensity[i]});
  }
  std::vector<WallColumn> out;
  for (const auto& [cell, all] : cells) {
    float top = all.front().p.z();
    for (const Upright& one : all) top = std::max(top, one.p.z());
    float low = top, intensity = 0.0F;
    Eigen::Vector2f place = Eigen::Vector2f::Zero(), normal = Eigen::Vector2f::Zero();
    std::size_t count = 0;
    for (const Upright& one : all) {
      if (one.p.z() < top - static_cast<float>(kTopReach_m)) continue;
      place += one.p.head<2>();
      low = std::min(low, one.p.z());
      intensity += one.intensity;
      normal += one.normal.dot(normal) < 0.0F ? Eigen::Vector2f(-one.normal) : one.normal;
      ++count;
    }
    const bool is_wall = count >= kLeastPoints && top - low > kLeastHigh_m &&
                         normal.norm() > kOneWay * static_cast<float>(count);
    if (!is_wall) continue;
    out.push_back({(place / static_cast<float>(count)).cast<double>(),
                   normal.normalized().cast<double>(),
                   static_cast<double>(top),
                   intensity / static_cast<float>(count)});
  }
  return out;
}

void WallObservations::refute() {
  if (refuted_ < std::numeric_limits<std::uint16_t>::max()) ++refuted_;
}

void WallObservations::add(float range_m, const Eigen::Vector3f& colour) {
  Observation look{range_m, {}};
  for (std::size_t c = 0; c < 3; ++c) {
    const float of_255 = 255.0F * std::clamp(colour[static_cast<Eigen::Index>(c)], 0.0F, 1.0F);
    look.colour[c] = static_cast<std::uint8_t>(std::lround(of_255));
  }
  if (count_ < kMost) {
    observations_[count_++] = look;
    return;
  }
  const auto farthest = std::max_element(
      observations_.begin(), observations_.end(), [](const Observation& a, const Observation& b) {
        return a.range_m < b.range_m;
      });
  if (range_m < farthest->range_m) *farthest = look;
}

std::optional<Eigen::Vector3f> WallObservations::agreed() const {
  if (count_ < kMinObservations || refuted_ > count_ / 2) return std::nullopt;
  const auto is_alike = [](const Colour& a, const Colour& b) {
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(a[c] - b[c]));
    return most <= kAlikeOf255;
  };
  int most = 0;
  Eigen::Vector3f best = Eigen::Vector3f::Zero();
  for (std::size_t i = 0; i < count_; ++i) {
    Eigen::Vector3i sum = Eigen::Vector3i::Zero();
    int alike = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      const Colour& colour = observations_[k].colour;
      if (!is_alike(observations_[i].colour, colour)) continue;
      sum += Eigen::Vector3i(colour[0], colour[1], colour[2]);
      ++alike;
    }
    if (alike <= most) continue;
    most = alike;
    best = sum.cast<float>() / (255.0F * static_cast<float>(alike));
  }
  if (static_cast<float>(most) < kAgreeing * static_cast<float>(count_)) return std::nullopt;
  return best;
}

std::size_t wall_steps(const std::vector<std::optional<Eigen::Vector3f>>& agreed, std::size_t gap) {
  std::size_t top = 0, unclear = 0;
  for (std::size_t i = 0; i < agreed.size() && unclear <= gap; ++i) {
    unclear = agreed[i] ? 0 : unclear + 1;
    const bool is_edge =
        i > 0 && agreed[i] && agreed[i - 1] && difference(*agreed[i - 1], *agreed[i]) > kEdge;
    if (is_edge) top = i;  // everything below step i
  }
  return top;
}

std::size_t WallsAbove::add_to(PointSet& points, const std::function<void()>& step) const {
  const double cell_m = wall_cell_m(voxel_m);
  const std::vector<WallColumn> columns = columns_of_walls(wall_columns(points, cell_m), cell_m);
  const auto steps = static_cast<std::size_t>(kHighest_m / cell_m);
  const auto gap = static_cast<std::size_t>(std::lround(kGap_m / cell_m));
  const auto place = [&](std::size_t column, std::size_t at) {
    const WallColumn& c = columns[column];
    return Eigen::Vector3d(
        c.position_m.x(), c.position_m.y(), c.top_m + (static_cast<double>(at) + 1.0) * cell_m);
  };
  std::vector<WallObservations> observations(columns.size() * steps);
  const PointBlocks blocks(points);
  if (!columns.empty()) expect(log, images, image_scale);
  for (const ImageFrame* frame : images) {
    if (columns.empty()) {
      step();
      continue;
    }
    const auto [image, view] = load_view(log, *frame, origin, image_scale);
    const PointSet known = actors.placed(points.subset(blocks.seen_from(view)), middle_s(*frame), view);
    NearestPoints nearest(view.camera());
    for (const SeenPoint& seen : seen_points(view, known)) {
      nearest.add(seen.pixel, seen.range_m, 0.5 * voxel_m / (view.pixel_size_at_1m() * seen.range_m));
    }
    const Eigen::Vector3d eye = view.origin();
    parallel_each(
        columns.size(),
        [&, &image = image, &view = view](std::size_t k) {
          const Eigen::Vector2d way = columns[k].position_m - eye.head<2>();
          const double away_m = way.norm();
          if (!(away_m > 1.0 && away_m < kFarthestLook_m)) return;
          const double cosine = std::abs(way.dot(columns[k].normal)) / away_m;
          if (!(away_m * view.pixel_size_at_1m() < kWidest_m * cosine)) return;
          for (std::size_t s = 0; s < steps; ++s) {
            Eigen::Vector2d pixel;
            double range_m = 0.0;
            if (!view.project(place(k, s), pixel, range_m) || nearest.hide(pixel, range_m)) continue;
            WallObservations& look = observations[k * steps + s];
            if (nearest.are_seen_through(pixel, range_m)) {
              look.refute();
            } else {
              look.add(static_cast<float>(range_m), sample_bilinear<3>(image, pixel));
            }
          }
        },
        64);
    step();
  }
  std::vector<double> tops(columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    std::vector<std::optional<Eigen::Vector3f>> agreed(steps);
    for (std::size_t s = 0; s < steps; ++s) agreed[s] = observations[k * steps + s].agreed();
    tops[k] = columns[k].top_m + static_cast<double>(wall_steps(agreed, gap)) * cell_m;
  }
  // A wall's height is the median of its columns.
  const std::vector<double> heights = heights_of_walls(columns, tops);
  PointSet above;
  std::vector<Eigen::Vector3f> found;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    for (std::size_t s = 0; s < steps && place(k, s).z() <= heights[k] + 1e-6; ++s)
      found.push_back(place(k, s).cast<float>());
  }
  above.position.resize(3, static_cast<Eigen::Index>(found.size()));
  for (std::size_t i = 0; i < found.size(); ++i) above.position.col(static_cast<Eigen::Index>(i)) = found[i];
  above.intensity.assign(found.size(), 0.0F);
  points.append(above);
  return found.size();
}

}  // namespace simuli
