#pragma once
// Nearest neighbours among the points of a PointSet.
#include <cstddef>
#include <cstdint>
#include <nanoflann.hpp>

#include "optim/init/points/points.hpp"

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

/// Calls f(index) for each point of a built tree within radius_m of query[3], in unspecified order.
template <class F>
void for_each_within(const PointTree& tree, const float* query, float radius_m, F&& f) {
  struct Found {  // a result set of nanoflann
    float radius2_m2;
    F& f;
    void init() {}
    void sort() {}
    [[nodiscard]] bool full() const { return true; }
    [[nodiscard]] float worstDist() const { return radius2_m2; }
    bool addPoint(float distance2_m2, std::uint32_t index) {
      if (distance2_m2 < radius2_m2) f(index);
      return true;
    }
  } found{radius_m * radius_m, f};
  tree.findNeighbors(found, query, {});
}

}  // namespace simuli
