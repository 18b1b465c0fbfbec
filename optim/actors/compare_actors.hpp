#pragma once
// Comparison of found actors with labelled ones.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// A labelled actor and the matching found actor.
struct ActorMatch {
  std::string labelled;
  std::string found;                                   // empty: missed
  std::size_t times = 0;                               // key poses of the found one at labelled times
  double labelled_s = 0.0;  // duration of the label
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  // of the found centre in the label's frame, median
  double centre_m = 0.0;  // median distance of the centres after removing that offset
  double centre_p90_m = 0.0;
  double turned_rad = 0.0;  // median difference between found and labelled heading
  double heading_rad = 0.0;  // median deviation from it
  Eigen::Vector3d labelled_size_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d found_size_m = Eigen::Vector3d::Zero();
};

struct ActorComparison {
  std::vector<ActorMatch> labels;  // actors that travel min_travel_m, in order
  std::vector<std::string> others;  // found actors without label
};

/// Matches a found actor with a label; no match when its centre is inside the label's box, enlarged by 1 m,
/// fewer than three times, or at less than half of the common times.
[[nodiscard]] std::optional<ActorMatch> match_actor(const Actor& labelled, const Actor& found);

/// Of several matching found actors a label gets the one that matches most often.
[[nodiscard]] ActorComparison compare_actors(const std::vector<Actor>& labelled,
                                             const std::vector<Actor>& found,
                                             double min_travel_m);

}  // namespace simuli
