#pragma once
// What colours a training starts with.
#include <cstddef>
#include <functional>

#include "optim/train/trainer_state.hpp"

namespace simuli {

/// Moves the camera set's colours of degree 0 by what every fourth picture of each camera asks of all particles at
/// once: a step of simultaneous iterative reconstruction (Gilbert 1972), in which each particle takes the mean of
/// what is missing where it shows, weighted by how much it shows there. Before, each has the colour of the one
/// picture that saw it from closest by. A tenth as many pictures as iterations at most: two take as long as one.
/// `progress`: pictures done, of how many. Error{kInput} when a picture can't be read.
void solve_first_colours(TrainerState& state,
                         const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli
