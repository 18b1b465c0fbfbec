#include "host/core/scene/occluders.hpp"

#include <algorithm>

namespace simuli {
namespace {

// Tolerances for a re-specified track to count as the recorded one.
constexpr double kSame_m = 0.1, kSame_rad = 0.02, kSameSize = 0.01;

bool is_same(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).norm() <= kSame_m &&
         a.rotation.angularDistance(b.rotation) <= kSame_rad;
}

}  // namespace

std::optional<std::size_t> OwnerNumbers::visibility_set_of(std::uint32_t number) const {
  if (number < visibility_set(0) || number >= disoccluded(0)) return std::nullopt;
  return number - visibility_set(0);
}

std::optional<std::size_t> OwnerNumbers::occluder_of(std::uint32_t number) const {
  if (number < disoccluded(0) || number > largest()) return std::nullopt;
  return (number - disoccluded(0)) / 2;
}

OwnerNumbers owner_numbers(const Scene& scene) {
  OwnerNumbers numbers{scene.actors.size(), scene.visibility_sets.size(), scene.occluders.size()};
  for (const VisibilitySet& visibility_set : scene.visibility_sets) numbers.occluders += visibility_set.occluders.size();
  return numbers;
}

std::uint32_t number_of_visibility_set(const Scene& scene, std::size_t index) {
  return owner_numbers(scene).visibility_set(index);
}
std::uint32_t disoccluded_number(const Scene& scene, std::size_t index) {
  return owner_numbers(scene).disoccluded(index);
}
std::uint32_t inpainted_number(const Scene& scene, std::size_t index) {
  return owner_numbers(scene).inpainted(index);
}
std::size_t most_numbers(const Scene& scene) { return owner_numbers(scene).largest(); }

std::vector<Occluder> occluders_of(const Scene& scene) {
  std::vector<Occluder> out;
  for (const Actor& occluder : scene.occluders) out.push_back({&occluder});
  for (std::size_t v = 0; v < scene.visibility_sets.size(); ++v) {
    for (const Actor& occluder : scene.visibility_sets[v].occluders) out.push_back({&occluder, v});
  }
  return out;
}

bool is_away(const Actor& occluder,
             const std::vector<Actor>& actors,
             double time_start_s,
             double time_end_s) {
  const double middle_s = 0.5 * (time_start_s + time_end_s);
  if (!occluder.is_there(middle_s)) return false;
  return std::none_of(actors.begin(), actors.end(), [&](const Actor& actor) {
    return actor.name == occluder.name && actor.is_there(middle_s) &&
           (actor.size_m - occluder.size_m).norm() <= kSameSize * occluder.size_m.norm() &&
           is_same(actor.at(time_start_s), occluder.at(time_start_s)) &&
           is_same(actor.at(time_end_s), occluder.at(time_end_s));
  });
}

std::vector<ActorView> owners_during(const Scene& scene,
                                     const std::vector<Actor>& actors,
                                     double time_start_s,
                                     double time_end_s,
                                     const std::optional<Eigen::Vector3d>& eye) {
  std::vector<ActorView> views = actors_during(actors, time_start_s, time_end_s, scene.origin);
  const std::vector<double> shares =
      eye ? visibility_shares(scene.visibility_sets, *eye) : std::vector<double>(scene.visibility_sets.size(), 1.0);
  for (const double share : shares) views.push_back({share > 0.0, {}, {}, {}, share});
  for (const Occluder& occluder : occluders_of(scene)) {
    const double share = occluder.visibility_set ? shares[*occluder.visibility_set] : 1.0;
    const bool away = share > 0.0 && is_away(*occluder.actor, actors, time_start_s, time_end_s);
    views.push_back({share > 0.0 && !away, {}, {}, {}, share});
    views.push_back({away, {}, {}, {}, share});
  }
  return views;
}

bool has_particles_of_actors(const Scene& scene, const GaussianSet& set) {
  const OwnerNumbers numbers = owner_numbers(scene);
  return std::any_of(
      set.actor.begin(), set.actor.end(), [&](std::uint32_t number) { return numbers.is_actor(number); });
}

void make_room_for_actor(const Scene& scene, GaussianSet& set) {
  for (std::uint32_t& number : set.actor) number += number > scene.actors.size() ? 1 : 0;
}

}  // namespace simuli
