#pragma once
// A street with the fine and thin things that the plain one lacks.
#include "io/synth/street_world.hpp"

namespace simuli::bench {

/// Trees of leaves and branches, kerbs that are lowered, poles, railings and bins, vehicles of several kinds,
/// worn markings, houses with balconies, shops and finer textures, with random numbers of its own: houses,
/// lamps, trunks and places of parked cars stay as they are in the plain street.
[[nodiscard]] const StreetDetail& detailed_street();

}  // namespace simuli::bench
