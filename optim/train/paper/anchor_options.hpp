#pragma once
#include "host/core/base/allowed.hpp"

namespace simuli {

/// The paper's anchoring loss L_anchor: camera particles stay near surfaces of the LiDAR set (METHOD section
/// 10). Off by default (docs/DECISIONS.md, "Removed features").
struct AnchorOptions {
  double weight = 0.0;
};
template <class F>
constexpr void visit_fields(AnchorOptions& o, F&& field) {
  field.group("Camera set");
  field("anchor.weight",
        o.weight,
        at_least(0.0),
        "Weight of camera particles' distance in m to the nearest LiDAR particle. 0.01: the paper's "
        "anchoring, slower and no better; 0: off.");
}

}  // namespace simuli
