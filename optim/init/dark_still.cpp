#include "optim/init/dark_still.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <variant>

#include "host/core/base/parallel.hpp"
#include "optim/init/dark_votes.hpp"
#include "optim/init/way_inside.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

constexpr double kOffVehicle_m = 1.5;     // from the sensor: not the vehicle itself
constexpr double kStep_m = 0.25;          // along a ray, on the way to the ground
constexpr double kDown = 0.02;            // of a ray's direction: how far down it looks at least
constexpr double kAboveGround_m = 0.3;    // along a ray: what is nearer to the ground may be the ground
constexpr double kBeforeReturn_m = 0.2;   // a thick surface is no way through itself
constexpr std::int64_t kBlockVoxels = 8;  // along each axis

using Key = std::uint64_t;

/// 21 bits an axis.
Key key_of(const Eigen::Vector3d& p, double side_m) {
  const auto bits = [side_m](double x) {
    constexpr std::int64_t kMiddle = std::int64_t{1} << 20U;
    return static_cast<Key>(static_cast<std::int64_t>(std::floor(x / side_m)) + kMiddle) & 0x1fffffU;
  };
  return bits(p.x()) << 42U | bits(p.y()) << 21U | bits(p.z());
}

/// How far it is from p along d out of its cell of `side_m`.
double way_out_m(const Eigen::Vector3d& p, const Eigen::Vector3d& d, double side_m) {
  double out_m = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (d[k] == 0.0) continue;
    const double cell = std::floor(p[k] / side_m);
    out_m = std::min(out_m, ((d[k] > 0.0 ? cell + 1.0 : cell) * side_m - p[k]) / d[k]);
  }
  return out_m;
}

/// Calls visit(ray, origin, direction, range_m) in the scene for all rays of a sweep but those in blind arcs, on
/// all cores.
template <class Visit>
void each_ray(const PosedSweep& posed, const Visit& visit) {
  const Sweep& sweep = posed.sweep;
  const auto* const lidar = std::get_if<Lidar>(&posed.lidar);
  parallel_ranges(sweep.range.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (lidar != nullptr && sweep.range[i] == 0.0F) {
        const auto row = static_cast<int>(i / static_cast<std::size_t>(lidar->columns));
        if (is_blind(*lidar, row, sweep.rays.azimuth[i])) continue;
      }
      const Pose scene_from_lidar =
          interpolate(posed.scene_from_lidar_start, posed.scene_from_lidar_end, sweep.rays.time_fraction[i]);
      const Eigen::Vector3d origin = scene_from_lidar * ray_origin(posed.lidar, sweep.rays, i);
      const Eigen::Vector3d direction =
          scene_from_lidar.rotation * Lidar::direction(sweep.rays.azimuth[i], sweep.rays.elevation[i]);
      visit(i, origin, direction, static_cast<double>(sweep.range[i]));
    }
  });
}

}  // namespace

struct DarkStill::Votes {
  double voxel_m;
  std::unordered_map<Key, DarkVotes> of;
  std::unordered_set<Key> blocks;  // with a voxel that has votes

  [[nodiscard]] double block_m() const { return voxel_m * static_cast<double>(kBlockVoxels); }

  /// Calls visit(key, place) for the voxels along a way, in order, until it returns false; `known`: only for
  /// those in blocks that have votes.
  template <class Visit>
  void walk(const Way& way, bool known, Visit&& visit) const {
    const double step_m = 0.5 * voxel_m;  // what is only grazed may be missed, and nothing counts twice
    Key last = std::numeric_limits<Key>::max(), block = last;
    bool is_known = !known;
    for (double t = way.from_m; t < way.to_m; t += step_m) {
      const Eigen::Vector3d p = way.origin + t * way.direction;
      if (const Key own = known ? key_of(p, block_m()) : block; own != block) {
        block = own;
        is_known = blocks.contains(own);
      }
      if (!is_known) {
        t += std::max(0.0, way_out_m(p, way.direction, block_m()) - step_m);
        continue;
      }
      const Key voxel = key_of(p, voxel_m);
      if (voxel == last) continue;
      last = voxel;
      if (!visit(voxel, p)) return;
    }
  }
};

DarkStill::DarkStill(const GroundMap& ground, double voxel_m)
    : ground_(ground), votes_(std::make_unique<Votes>(Votes{voxel_m, {}, {}})) {}

DarkStill::~DarkStill() = default;

void DarkStill::add_dropped(const PosedSweep& posed, const std::vector<MovingBox>& boxes) {
  const std::vector<float>& shares = posed.sweep.rays.time_fraction;
  std::vector<Way> ways(shares.size());  // none: one without a length
  each_ray(posed, [&](std::size_t ray, const Vector3d& origin, const Vector3d& direction, double range_m) {
    if (range_m > 0.0 || direction.z() > -kDown) return;
    const auto meets = [&](const MovingBox& box) {
      const Pose scene_from_box = interpolate(box.scene_from_box_start, box.scene_from_box_end, shares[ray]);
      const Pose box_from_scene = scene_from_box.inverse();
      const auto [first, last] =
          way_inside(box_from_scene * origin, box_from_scene.rotation * direction, box.half);
      return first < last && first < kGround_m;
    };
    if (std::any_of(boxes.begin(), boxes.end(), meets)) return;
    double from_m = 0.0;
    for (double t = kOffVehicle_m; t < kGround_m; t += kStep_m) {
      const Eigen::Vector3d p = origin + t * direction;
      const auto ground_z = ground_.height_m(p.x(), p.y());
      if (!ground_z) continue;
      if (from_m == 0.0 && p.z() < *ground_z + kHeight_m) from_m = t;
      if (p.z() >= *ground_z) continue;
      ways[ray] = {origin, direction, from_m, t - kAboveGround_m};
      return;
    }
  });
  for (const Way& way : ways) {
    if (!(way.from_m < way.to_m)) continue;
    votes_->walk(way, false, [&](Key voxel, const Eigen::Vector3d& place) {
      ++votes_->of[voxel].dropped;
      votes_->blocks.insert(key_of(place, votes_->block_m()));
      return true;
    });
    dropped_.push_back(way);
  }
}

void DarkStill::add_returned(const PosedSweep& posed) {
  each_ray(posed, [&](std::size_t, const Vector3d& origin, const Vector3d& direction, double range_m) {
    if (!(range_m > 0.0)) return;
    const Way way{origin, direction, kOffVehicle_m, std::min(range_m - kBeforeReturn_m, kGround_m)};
    votes_->walk(way, true, [&](Key voxel, const Eigen::Vector3d&) {
      const auto found = votes_->of.find(voxel);
      // Counts are the same in any order.
      if (found != votes_->of.end())
        std::atomic_ref(found->second.through).fetch_add(1, std::memory_order_relaxed);
      return true;
    });
  });
}

PointSet DarkStill::points() const {
  VoxelGrid grid(votes_->voxel_m);
  for (const Way& way : dropped_) {
    votes_->walk(way, false, [&](Key voxel, const Eigen::Vector3d& place) {
      if (!votes_->of.at(voxel).is_dark()) return true;
      grid.add(place, 0.0);
      return false;
    });
  }
  return grid.averages();
}

}  // namespace simuli
