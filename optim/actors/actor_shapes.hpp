#pragma once
// Optimises the deformations of non-rigid actors (METHOD section 2).
#include <cstdint>
#include <span>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/device/render/backward/deform_bwd.hpp"

namespace simuli {

/// Decides by the actor's kind; for kinds without information by the size of a pedestrian or a rider.
[[nodiscard]] bool is_non_rigid(const Actor& actor);

/// Gives non-rigid actors without a deformation a zero deformation over the time of their tracks.
void prepare_shapes(std::vector<Actor>& actors);

/// The optimiser of deformations for one particle set; all sets share the deformations.
class ActorShapes {
 public:
  explicit ActorShapes(bool learns) : learns_(learns) {}
  [[nodiscard]] bool learns() const { return learns_; }

  /// Takes one step with the gradients of a frame, in the order of `actors`: knots used by the frame move and
  /// are smoothed. Non-finite gradients change nothing.
  void step(std::vector<Actor>& actors,
            const std::vector<DeformationGradient>& gradients,
            double time_start_s,
            double time_end_s,
            double progress);

  /// Checkpoint state of the optimiser, by the deformations of `actors`, in order.
  [[nodiscard]] std::vector<double> numbers(const std::vector<Actor>& actors) const;
  void set_numbers(const std::vector<Actor>& actors, std::span<const double> numbers);

 private:
  struct Moments {
    std::vector<double> first, second;  // layout of Deformation::offsets_m
    std::vector<double> steps;          // [knots]
  };
  void move(Deformation& shape,
            Moments& moments,
            std::size_t knot,
            const std::vector<double>& gradient,
            double rate);
  void smooth(Deformation& shape, std::size_t knot) const;

  bool learns_;
  std::vector<Moments> moments_;  // [actors]
};

}  // namespace simuli
