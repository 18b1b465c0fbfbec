#include "optim/init/dark_still.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <unordered_map>

#include "host/core/base/parallel.hpp"
#include "host/device/render/scene/actor_boxes.hpp"
#include "optim/init/dark_votes.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

constexpr double kOffVehicle_m = 1.5;  // distance from the sensor that excludes the ego vehicle
constexpr double kStep_m = 0.25;  // step along a ray towards the ground
constexpr double kDown = 0.02;  // smallest downward component of a ray's direction
constexpr double kAboveGround_m = 0.3;  // along a ray: nearer to the ground may be the ground itself
constexpr double kBeforeReturn_m = 0.2;  // a thick surface does not contradict itself

using Key = std::uint64_t;
using Cell = Eigen::Array<std::int64_t, 3, 1>;

/// Half of the 2^21 cells along each axis.
constexpr std::int64_t kMiddle = std::int64_t{1} << 20U;

/// Rounds down by truncation of values above 0, which avoids calls of floor().
Cell cell_of(const Eigen::Vector3d& p, double cells_per_m) {
  return (p.array() * cells_per_m + static_cast<double>(kMiddle)).cast<std::int64_t>() - kMiddle;
}

/// Packs 21 bits per axis.
Key key_of(const Cell& cell) {
  const auto bits = [](std::int64_t at) { return static_cast<Key>(at + kMiddle) & 0x1fffffU; };
  return bits(cell.x()) << 42U | bits(cell.y()) << 21U | bits(cell.z());
}

/// Distance in m from p along d to the border of its cell of `side_m`.
double way_out_m(const Eigen::Vector3d& p, const Eigen::Vector3d& d, double side_m) {
  double out_m = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (d[k] == 0.0) continue;
    const double cell = std::floor(p[k] / side_m);
    out_m = std::min(out_m, ((d[k] > 0.0 ? cell + 1.0 : cell) * side_m - p[k]) / d[k]);
  }
  return out_m;
}

/// Calls visit(ray, origin, direction, range_m) in the scene frame for all rays of a sweep outside blind arcs,
/// on all cores.
template <class Visit>
void each_ray(const PosedSweep& posed, const Visit& visit) {
  const Sweep& sweep = posed.sweep;
  parallel_each(sweep.range.size(), [&](std::size_t i) {
    if (is_blind(posed.lidar, sweep.rays, i)) return;
    const auto [origin, direction] = ray_in_scene(posed, i);
    visit(i, origin, direction, static_cast<double>(sweep.range[i]));
  });
}

}  // namespace

/// Votes of voxels in cubic blocks: a ray passes many voxels of a block, and most of space has no block.
struct DarkStill::Votes {
  static constexpr std::int64_t kBits = 3, kSide = std::int64_t{1} << kBits;  // voxels
  using Block = std::array<DarkVotes, std::size_t{1} << (3 * kBits)>;
  double voxel_m;
  std::unordered_map<Key, std::unique_ptr<Block>> blocks;

  [[nodiscard]] double block_m() const { return voxel_m * static_cast<double>(kSide); }
  [[nodiscard]] static Cell block_of(const Cell& voxel) {
    return voxel.unaryExpr([](std::int64_t at) { return at >> kBits; });
  }
  [[nodiscard]] static std::size_t place_in_block(const Cell& voxel) {
    const auto low = [](std::int64_t at) { return static_cast<std::size_t>(at & (kSide - 1)); };
    return (low(voxel.z()) << (2 * kBits)) | (low(voxel.y()) << kBits) | low(voxel.x());
  }

  /// Calls visit(votes, place) for the voxels along a segment, in order, until it returns false. block(key):
  /// votes of a block, or null to skip it.
  template <class BlockOf, class Visit>
  void walk(const Way& way, const BlockOf& block, const Visit& visit) const {
    const double step_m = 0.5 * voxel_m;  // may miss grazed voxels; no voxel counts twice
    const double voxels_per_m = 1.0 / voxel_m;
    constexpr std::int64_t kNowhere = std::numeric_limits<std::int64_t>::max();
    Cell last = Cell::Constant(kNowhere), last_block = last;
    Block* votes = nullptr;
    for (double t = way.from_m; t < way.to_m; t += step_m) {
      const Eigen::Vector3d p = way.origin + t * way.direction;
      const Cell voxel = cell_of(p, voxels_per_m);
      if ((voxel == last).all()) continue;
      last = voxel;
      if (const Cell own = block_of(voxel); (own != last_block).any()) {
        last_block = own;
        votes = block(key_of(own));
      }
      if (votes == nullptr) {
        t += std::max(0.0, way_out_m(p, way.direction, block_m()) - step_m);
        continue;
      }
      if (!visit((*votes)[place_in_block(voxel)], p)) return;
    }
  }
  /// Returns the block, or null.
  [[nodiscard]] Block* found(Key key) const {
    const auto at = blocks.find(key);
    return at == blocks.end() ? nullptr : at->second.get();
  }
  [[nodiscard]] Block* made(Key key) {
    std::unique_ptr<Block>& block = blocks[key];
    if (!block) block = std::make_unique<Block>();
    return block.get();
  }
};

DarkStill::DarkStill(const GroundMap& ground, double voxel_m)
    : ground_(ground), votes_(std::make_unique<Votes>(Votes{voxel_m, {}})) {}

DarkStill::~DarkStill() = default;

void DarkStill::add_dropped(const PosedSweep& posed, const std::vector<MovingBox>& boxes) {
  const std::vector<float>& shares = posed.sweep.rays.time_fraction;
  std::vector<Way> ways(shares.size());  // empty: zero length
  each_ray(posed, [&](std::size_t ray, const Vector3d& origin, const Vector3d& direction, double range_m) {
    if (range_m > 0.0 || direction.z() > -kDown) return;
    const auto meets = [&](const MovingBox& box) {
      const Pose scene_from_box = interpolate(box.scene_from_box_start, box.scene_from_box_end, shares[ray]);
      const Pose box_from_scene = scene_from_box.inverse();
      const BoxInterval in =
          inside_box(box_from_scene * origin, box_from_scene.rotation * direction, box.half);
      const double first = std::max(in.first, 0.0);
      return first < in.last && first < kGround_m;
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
    votes_->walk(
        way,
        [&](Key block) { return votes_->made(block); },
        [](DarkVotes& votes, const Vector3d&) {
          ++votes.dropped;
          return true;
        });
    dropped_.push_back(way);
  }
}

void DarkStill::add_returned(const PosedSweep& posed) {
  each_ray(posed, [&](std::size_t, const Vector3d& origin, const Vector3d& direction, double range_m) {
    if (!(range_m > 0.0)) return;
    const Way way{origin, direction, kOffVehicle_m, std::min(range_m - kBeforeReturn_m, kGround_m)};
    votes_->walk(
        way,
        [&](Key block) { return votes_->found(block); },
        [](DarkVotes& votes, const Vector3d&) {
          // Counts do not depend on the order.
          std::atomic_ref(votes.through).fetch_add(1, std::memory_order_relaxed);
          return true;
        });
  });
}

PointSet DarkStill::points() const {
  VoxelGrid grid(votes_->voxel_m);
  for (const Way& way : dropped_) {
    votes_->walk(
        way,
        [&](Key block) { return votes_->found(block); },
        [&](const DarkVotes& votes, const Vector3d& place) {
          if (!votes.is_dark()) return true;
          grid.add(place, 0.0);
          return false;
        });
  }
  return grid.averages();
}

}  // namespace simuli
