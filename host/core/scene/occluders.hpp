#pragma once
// What stands behind actors. A place that is never seen but behind an actor has particles twice: those that
// training came to while nobody could see them, shown as long as the actor is where it was recorded, so that
// recorded views stay what they are; and those that fill it plausibly from around, shown while the actor is
// recorded there and is elsewhere.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/core/scene/scene.hpp"

namespace simuli {

/// The one layout of GaussianSet::actor: 0 is the background, then follow the actors, the vistas, and for each
/// occluder two numbers: the particles behind it, and the particles instead of those. The view of number n is
/// owners_during()[n - 1].
struct OwnerNumbers {
  std::size_t actors = 0, vistas = 0, occluders = 0;  // how many there are

  [[nodiscard]] std::uint32_t actor(std::size_t index) const { return at(index); }
  [[nodiscard]] std::uint32_t vista(std::size_t index) const { return at(actors + index); }
  [[nodiscard]] std::uint32_t behind(std::size_t index) const { return at(actors + vistas + 2 * index); }
  [[nodiscard]] std::uint32_t instead(std::size_t index) const { return behind(index) + 1; }
  [[nodiscard]] std::size_t largest() const { return actors + vistas + 2 * occluders; }

  [[nodiscard]] bool is_actor(std::uint32_t number) const { return number > 0 && number <= actors; }
  /// Returns the index of the vista; empty for the number of another owner.
  [[nodiscard]] std::optional<std::size_t> vista_of(std::uint32_t number) const;
  /// Returns the index of the occluder that the particles are behind or instead of; empty for another owner.
  [[nodiscard]] std::optional<std::size_t> occluder_of(std::uint32_t number) const;

 private:
  static std::uint32_t at(std::size_t owners_before) { return static_cast<std::uint32_t>(owners_before + 1); }
};
[[nodiscard]] OwnerNumbers owner_numbers(const Scene& scene);

/// GaussianSet::actor of what is of Scene::vistas[index], in the scene's frame.
[[nodiscard]] std::uint32_t number_of_vista(const Scene& scene, std::size_t index);
/// An actor that hides something; of which vista, if of one.
struct Occluder {
  const Actor* actor = nullptr;
  std::optional<std::size_t> vista = {};
};
/// The scene's own, then each vista's.
[[nodiscard]] std::vector<Occluder> occluders_of(const Scene& scene);
/// GaussianSet::actor of what is hidden behind occluders_of()[index], and of what is there instead. Their
/// parameters are in the scene's frame.
[[nodiscard]] std::uint32_t number_behind(const Scene& scene, std::size_t index);
[[nodiscard]] std::uint32_t number_instead(const Scene& scene, std::size_t index);
/// The largest GaussianSet::actor that particles of the scene may have.
[[nodiscard]] std::size_t most_numbers(const Scene& scene);

/// Whether the actor was recorded half-way through the frame, and of `actors` none of its name and size is
/// within 0.1 m and 1 degree of where it was, from the frame's start to its end.
[[nodiscard]] bool is_away(const Actor& occluder,
                           const std::vector<Actor>& actors,
                           double time_start_s,
                           double time_end_s);

/// Views of all that particles of the scene belong to, in the order of their numbers: `actors`, which are the
/// scene's or edited ones, then the vistas as they are seen from `eye` (world, m; none: all of them), then
/// what is behind and instead of each occluder, a vista's by the share of that.
[[nodiscard]] std::vector<ActorView> owners_during(const Scene& scene,
                                                   const std::vector<Actor>& actors,
                                                   double time_start_s,
                                                   double time_end_s,
                                                   const std::optional<Eigen::Vector3d>& eye);

/// Whether one of the set's particles is an actor's, whom others can't take the place of in another number.
[[nodiscard]] bool has_particles_of_actors(const Scene& scene, const GaussianSet& set);

/// Numbers of `set` with one more actor of the scene, behind those there are.
void make_room_for_actor(const Scene& scene, GaussianSet& set);

}  // namespace simuli
