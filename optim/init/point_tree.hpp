#pragma once
// Nearest neighbours among the points of a PointSet.
#include <cstddef>
#include <cstdint>
#include <nanoflann.hpp>

#include "optim/init/initialize_points.hpp"

namespace simuli {

struct CloudView {
  const PointSet& points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points.position(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(i));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

/// knnSearch(query[3], k, indices[k], squared_distances[k]) once buildIndex() has run.
using PointTree = nanoflann::
    KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, CloudView>, CloudView, 3, std::uint32_t>;

}  // namespace simuli
