#pragma once
// How wide a pixel is taken: what a camera set is widened by (docs/METHOD.md, section 8).

namespace simuli {

/// px^2, variance of a square pixel: what scenes are trained with unless asked.
inline constexpr double kPixelVariance_px2 = 1.0 / 12.0;
/// px^2, what 3DGS and the programs after it take, and scenes that don't say were trained with.
inline constexpr double kSplatVariance_px2 = 0.3;

}  // namespace simuli
