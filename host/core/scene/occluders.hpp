#pragma once
// Disocclusions: parts of the scene that recorded views never show because an actor hides them. For each such actor
// (an occluder) a scene has two Gaussian sets: the disoccluded set, Gaussians that training left there unseen, which
// is rendered while the actor is at its recorded pose, so that recorded views keep their bits; and the inpainted set,
// a plausible fill from the surroundings, which is rendered when the actor has been moved or removed.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/core/scene/scene.hpp"

namespace simuli {

/// Layout of GaussianSet::actor, the owner number of each particle: 0 for the background, then the actors, the
/// visibility sets, and two numbers for each occluder: its disoccluded set and its inpainted set. The view of number n
/// is owners_during()[n - 1].
struct OwnerNumbers {
  std::size_t actors = 0, visibility_sets = 0, occluders = 0;  // counts

  [[nodiscard]] std::uint32_t actor(std::size_t index) const { return at(index); }
  [[nodiscard]] std::uint32_t visibility_set(std::size_t index) const { return at(actors + index); }
  [[nodiscard]] std::uint32_t disoccluded(std::size_t index) const { return at(actors + visibility_sets + 2 * index); }
  [[nodiscard]] std::uint32_t inpainted(std::size_t index) const { return disoccluded(index) + 1; }
  [[nodiscard]] std::size_t largest() const { return actors + visibility_sets + 2 * occluders; }

  [[nodiscard]] bool is_actor(std::uint32_t number) const { return number > 0 && number <= actors; }
  /// Returns the index of the visibility_set; empty for the number of another owner.
  [[nodiscard]] std::optional<std::size_t> visibility_set_of(std::uint32_t number) const;
  /// Returns the index of the occluder that the particles are behind or instead of; empty for another owner.
  [[nodiscard]] std::optional<std::size_t> occluder_of(std::uint32_t number) const;

 private:
  static std::uint32_t at(std::size_t owners_before) { return static_cast<std::uint32_t>(owners_before + 1); }
};
[[nodiscard]] OwnerNumbers owner_numbers(const Scene& scene);

/// Returns the owner number of Scene::visibility_sets[index]. Parameters of these particles are in the scene's frame.
[[nodiscard]] std::uint32_t number_of_visibility_set(const Scene& scene, std::size_t index);
/// An actor that hides part of the scene; with the index of its visibility set, if it belongs to one.
struct Occluder {
  const Actor* actor = nullptr;
  std::optional<std::size_t> visibility_set = {};
};
/// Returns the occluders of the scene, then those of each visibility set.
[[nodiscard]] std::vector<Occluder> occluders_of(const Scene& scene);
/// Returns the owner numbers of the disoccluded and the inpainted set of occluders_of()[index]. Parameters of these
/// particles are in the scene's frame.
[[nodiscard]] std::uint32_t disoccluded_number(const Scene& scene, std::size_t index);
[[nodiscard]] std::uint32_t inpainted_number(const Scene& scene, std::size_t index);
/// Returns the largest owner number of the scene.
[[nodiscard]] std::size_t most_numbers(const Scene& scene);

/// Whether `occluder` was recorded at the middle of the frame, and none of `actors` with its name and size is within
/// 0.1 m and 1 degree of its recorded pose at the frame's start and end.
[[nodiscard]] bool is_away(const Actor& occluder,
                           const std::vector<Actor>& actors,
                           double time_start_s,
                           double time_end_s);

/// Returns the view of each owner, by owner number from 1 on: `actors` (the scene's or edited ones), the visibility sets
/// as seen from `eye` (world, m; without a value: all of them), then the disoccluded and the inpainted set of each
/// occluder. Occluders of a visibility set have its share.
[[nodiscard]] std::vector<ActorView> owners_during(const Scene& scene,
                                                   const std::vector<Actor>& actors,
                                                   double time_start_s,
                                                   double time_end_s,
                                                   const std::optional<Eigen::Vector3d>& eye);

/// Whether any particle of the set belongs to an actor.
[[nodiscard]] bool has_particles_of_actors(const Scene& scene, const GaussianSet& set);

/// Renumbers the owners in `set` for a scene with one more actor after the existing ones.
void make_room_for_actor(const Scene& scene, GaussianSet& set);

}  // namespace simuli
