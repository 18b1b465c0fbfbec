#include "host/core/record/mirror.hpp"

#include <algorithm>
#include <vector>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

constexpr double kSeenShare = 0.1;

/// Mirrors a particle: y becomes -y. Rotations about x and z change their sign, and so do the spherical
/// harmonics with m < 0.
void mirror_row(GaussianSet& set, Eigen::Index row) {
  set.mean()(row, 1) *= -1.0F;
  set.rotation()(row, 1) *= -1.0F;
  set.rotation()(row, 3) *= -1.0F;
  for (int l = 1; l <= set.sh_degree; ++l) {
    for (int m = -l; m < 0; ++m) set.sh(l * l + l + m).row(row) *= -1.0F;
  }
}

/// Replaces the particles of the unseen side (by the sign of y).
void mirror_set(GaussianSet& set, std::uint32_t number, float unseen) {
  std::vector<Eigen::Index> kept, copied;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const bool is_own = !set.actor.empty() && set.actor[static_cast<std::size_t>(i)] == number;
    const float side = is_own ? unseen * set.mean()(i, 1) : 0.0F;
    if (side <= 0.0F) kept.push_back(i);
    if (is_own && side < 0.0F) copied.push_back(i);
  }
  Eigen::MatrixXf params(static_cast<Eigen::Index>(kept.size() + copied.size()), set.params.cols());
  std::vector<std::uint32_t> actor;
  for (const std::vector<Eigen::Index>* rows : {&kept, &copied}) {
    for (const Eigen::Index i : *rows) {
      params.row(static_cast<Eigen::Index>(actor.size())) = set.params.row(i);
      actor.push_back(set.actor.empty() ? 0U : set.actor[static_cast<std::size_t>(i)]);
    }
  }
  set.params = std::move(params);
  if (!set.actor.empty()) set.actor = std::move(actor);
  for (Eigen::Index i = static_cast<Eigen::Index>(kept.size()); i < set.size(); ++i) mirror_row(set, i);
}

}  // namespace

SidesSeen sides_seen(const SupportRecord& record, const std::string& actor) {
  const Actor& recorded = record.actors[find_actor(record.actors, actor)];
  SidesSeen seen;
  for (const SupportView& view : record.views) {
    if (!recorded.is_there(view.time_s)) continue;
    const Eigen::Vector3d p_actor = recorded.at(view.time_s).inverse() * view.world_from_view.translation;
    // The actor must be inside the view.
    const Eigen::Vector3d p_view = view.world_from_view.inverse() * recorded.at(view.time_s).translation;
    const SupportGrid& grid = record.sensors[view.sensor].grid;
    if (grid.cell_of(p_view) >= grid.cells()) continue;
    const double across = p_actor.y() / std::max(p_actor.norm(), 1e-9);
    seen.left += across > kSidewards ? 1U : 0U;
    seen.right += across < -kSidewards ? 1U : 0U;
  }
  return seen;
}

bool mirror_actor(Scene& scene,
                  const SupportRecord& record,
                  const std::string& actor,
                  const std::string& recorded) {
  const auto number = static_cast<std::uint32_t>(find_actor(scene.actors, actor) + 1);
  const SidesSeen seen = sides_seen(record, recorded);
  const double least = kSeenShare * static_cast<double>(seen.left + seen.right);
  const bool has_left = static_cast<double>(seen.left) > least,
             has_right = static_cast<double>(seen.right) > least;
  if (has_left == has_right) return false;
  const float unseen = has_left ? -1.0F : 1.0F;
  for (GaussianSet* const set : {&scene.camera, &scene.lidar}) mirror_set(*set, number, unseen);
  return true;
}

}  // namespace simuli
