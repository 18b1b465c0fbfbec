#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "host/core/scene/edit.hpp"
#include "host/core/scene/occluders.hpp"
#include "host/core/scene/particle_order.hpp"
#include "host/core/scene/placement.hpp"

namespace simuli {
namespace {

/// Returns the particles of that owner (GaussianSet::actor), without owner numbers.
GaussianSet of_owner(const GaussianSet& set, std::uint32_t number) {
  if (set.actor.empty()) return number == 0 ? set : GaussianSet(set.kind, set.sh_degree, 0);
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < set.actor.size(); ++i) {
    if (set.actor[i] == number) rows.push_back(static_cast<Eigen::Index>(i));
  }
  GaussianSet out = subset(set, rows);
  out.actor.clear();
  return out;
}

void deform(GaussianSet& set, const DeformationView& shape) {
  if (shape.empty()) return;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const Eigen::Vector3d mean = set.mean().row(i).transpose().cast<double>();
    const Eigen::Vector3d offset = deformation_at(shape.nodes, shape.half_m, shape.start_m, mean);
    set.mean().row(i) = (mean + offset).cast<float>().transpose();
  }
}

/// Keeps the particles of a visibility set that are nearest to its own path, so that several sets do not
/// represent the same place twice.
GaussianSet nearest_to(const Scene& scene, std::size_t visibility_set, GaussianSet set) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const Eigen::Vector3d p_scene = set.mean().row(i).transpose().cast<double>();
    if (nearest_visibility_set(scene.visibility_sets, p_scene + scene.origin) == visibility_set)
      rows.push_back(i);
  }
  return static_cast<std::size_t>(set.size()) == rows.size() ? set : subset(set, rows);
}

GaussianSet joined(const std::vector<GaussianSet>& parts) {
  Eigen::Index count = 0, row = 0;
  for (const GaussianSet& part : parts) count += part.size();
  GaussianSet out(parts.front().kind, parts.front().sh_degree, count);
  for (const GaussianSet& part : parts) {
    out.params.middleRows(row, part.size()) = part.params;
    row += part.size();
  }
  return out;
}

/// Returns the visibility set of an owner number, directly or through its occluder.
std::optional<std::size_t> visibility_set_of(const Scene& scene, std::uint32_t number) {
  const OwnerNumbers numbers = owner_numbers(scene);
  if (const auto occluder = numbers.occluder_of(number)) return occluders_of(scene)[*occluder].visibility_set;
  return numbers.visibility_set_of(number);
}

const GaussianSet& set_of(const Scene& scene, SetKind kind) {
  return kind == SetKind::kCamera ? scene.camera : scene.lidar;
}

}  // namespace

GaussianSet background_of(const Scene& scene, SetKind kind) {
  const GaussianSet& set = set_of(scene, kind);
  std::vector<GaussianSet> parts{of_owner(set, 0)};
  for (std::size_t i = 0; i < scene.visibility_sets.size(); ++i)
    parts.push_back(nearest_to(scene, i, of_owner(set, number_of_visibility_set(scene, i))));
  const std::vector<Occluder> occluders = occluders_of(scene);
  for (std::size_t i = 0; i < occluders.size(); ++i) {
    GaussianSet instead = of_owner(set, inpainted_number(scene, i));
    if (occluders[i].visibility_set)
      instead = nearest_to(scene, *occluders[i].visibility_set, std::move(instead));
    parts.push_back(std::move(instead));
  }
  return joined(parts);
}

GaussianSet moment_of(const Scene& scene, SetKind kind, double time_s) {
  const GaussianSet& set = set_of(scene, kind);
  std::vector<GaussianSet> parts{of_owner(set, 0)};
  const auto views = owners_during(scene, scene.actors, time_s, time_s, std::nullopt);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].is_there) continue;
    const auto number = static_cast<std::uint32_t>(i + 1);
    parts.push_back(of_owner(set, number));
    if (const auto visibility_set = visibility_set_of(scene, number))
      parts.back() = nearest_to(scene, *visibility_set, std::move(parts.back()));
    deform(parts.back(), views[i].deformation);
    transform(parts.back(), views[i].scene_from_actor_start);
  }
  return joined(parts);
}

}  // namespace simuli
