#pragma once
#include <vector>

#include "optim/init/points/points.hpp"

namespace simuli::test {

inline PointSet point_set(const std::vector<Eigen::Vector3f>& positions) {
  PointSet set;
  set.position.resize(3, static_cast<Eigen::Index>(positions.size()));
  for (std::size_t i = 0; i < positions.size(); ++i)
    set.position.col(static_cast<Eigen::Index>(i)) = positions[i];
  set.intensity.assign(positions.size(), 0.5F);
  return set;
}

}  // namespace simuli::test
