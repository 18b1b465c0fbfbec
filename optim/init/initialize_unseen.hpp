#pragma once
// What the laser met and no picture shows: the far side of what stood before it, and what lies just outside
// the pictures. It comes into sight when a camera leaves the recorded path.
#include <cstddef>
#include <vector>

#include "optim/init/initialize_views.hpp"
#include "optim/points/points.hpp"

namespace simuli {

/// Points without a look that one of the views would have in its picture were it up to off_path_m to either
/// side, or above.
struct UnseenPoints {
  PointSet points;
  /// As seen from the nearest of those views; the colour is that of the nearest points that pictures show and
  /// that face, reflect and lie high alike.
  std::vector<PointLook> looks;
};

/// `looks`: [points]. Nothing when no point has a look, or off_path_m is 0.
[[nodiscard]] UnseenPoints unseen_points(const PointSet& points,
                                         const std::vector<PointLook>& looks,
                                         const std::vector<ImageView>& views,
                                         double off_path_m);

}  // namespace simuli
