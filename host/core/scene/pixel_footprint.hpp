#pragma once
// Footprint of a pixel, by which a camera set is widened (docs/METHOD.md, section 8).

namespace simuli {

/// px^2, variance of a square pixel: the default of trainings.
inline constexpr double kPixelVariance_px2 = 1.0 / 12.0;
/// px^2, as in 3DGS and later programs; assumed for scenes that do not specify it.
inline constexpr double kSplatVariance_px2 = 0.3;

}  // namespace simuli
