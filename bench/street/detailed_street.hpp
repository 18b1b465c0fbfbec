#pragma once
// A street with fine and thin objects that the plain street lacks.
#include "io/synth/street_world.hpp"

namespace simuli::bench {

/// Returns the details: trees of leaves and branches, lowered kerbs, poles, railings and bins, several kinds
/// of vehicles, worn markings, houses with balconies, shops and finer textures. Their random numbers are
/// separate: houses, lamps, trunks and positions of parked cars equal the plain street's.
[[nodiscard]] const StreetDetail& detailed_street();

}  // namespace simuli::bench
