#include "host/scene/moment.hpp"

#include <vector>

#include "host/scene/particle_order.hpp"
#include "host/scene/placement.hpp"

namespace simuli {
namespace {

GaussianSet of_actor(const GaussianSet& set, std::uint32_t actor) {
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < set.actor.size(); ++i) {
    if (set.actor[i] == actor) rows.push_back(static_cast<Eigen::Index>(i));
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

}  // namespace

GaussianSet background_of(const GaussianSet& set) { return set.actor.empty() ? set : of_actor(set, 0); }

GaussianSet moment_of(const Scene& scene, SetKind kind, double time_s) {
  const GaussianSet& set = kind == SetKind::kCamera ? scene.camera : scene.lidar;
  std::vector<GaussianSet> parts{background_of(set)};
  Eigen::Index count = parts.front().size();
  const auto views = actors_during(scene.actors, time_s, time_s, scene.origin);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].is_there) continue;
    parts.push_back(of_actor(set, static_cast<std::uint32_t>(i + 1)));
    deform(parts.back(), views[i].deformation);
    transform(parts.back(), views[i].scene_from_actor_start);
    count += parts.back().size();
  }
  GaussianSet out(set.kind, set.sh_degree, count);
  Eigen::Index row = 0;
  for (const GaussianSet& part : parts) {
    out.params.middleRows(row, part.size()) = part.params;
    row += part.size();
  }
  return out;
}

}  // namespace simuli
