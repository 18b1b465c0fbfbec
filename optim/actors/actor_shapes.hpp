#pragma once
// Learns how actors that are not rigid change their shape (METHOD section 2).
#include <cstdint>
#include <span>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/device/render/backward/deform_bwd.hpp"

namespace simuli {

/// By its kind, as labels have it; of a kind that says nothing by its size: as large as a person or a rider.
[[nodiscard]] bool is_non_rigid(const Actor& actor);

/// Gives those actors that are not rigid, and have none, a deformation of zeros for as long as their tracks
/// last.
void prepare_shapes(std::vector<Actor>& actors);

/// One particle set's optimiser of the shapes, which all sets share.
class ActorShapes {
 public:
  explicit ActorShapes(bool learns) : learns_(learns) {}
  [[nodiscard]] bool learns() const { return learns_; }

  /// One step by the gradients of a frame, in the order of `actors`: knots that the frame has to do with
  /// move, and are drawn to their neighbours. What is not finite moves nothing.
  void step(std::vector<Actor>& actors,
            const std::vector<DeformationGradient>& gradients,
            double time_start_s,
            double time_end_s,
            double progress);

  /// What a checkpoint holds of the optimiser, by the deformations of `actors`, in their order.
  [[nodiscard]] std::vector<double> numbers(const std::vector<Actor>& actors) const;
  void set_numbers(const std::vector<Actor>& actors, std::span<const double> numbers);

 private:
  struct Moments {
    std::vector<double> first, second;  // as Deformation::offsets_m
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
