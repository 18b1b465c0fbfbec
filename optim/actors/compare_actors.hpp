#pragma once
// Found actors beside labelled ones.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// A labelled actor and the found one that is it.
struct ActorMatch {
  std::string labelled;
  std::string found;                                   // empty: missed
  std::size_t times = 0;                               // key poses of the found one at labelled times
  double labelled_s = 0.0;                             // that the label lasts
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  // of the found centre in the label's frame, median
  double centre_m = 0.0;  // median distance of the centres once that offset is taken off
  double centre_p90_m = 0.0;
  double turned_rad = 0.0;   // median of the found heading less the labelled
  double heading_rad = 0.0;  // median deviation from that
  Eigen::Vector3d labelled_size_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d found_size_m = Eigen::Vector3d::Zero();
};

struct ActorComparison {
  std::vector<ActorMatch> labels;   // those that travel min_travel_m, in their order
  std::vector<std::string> others;  // found ones that are none of them
};

/// The found actor beside the label; none: its centre is in the label's box, widened by 1 m, fewer than three
/// times, or at less than half of the times that both are there.
[[nodiscard]] std::optional<ActorMatch> match_actor(const Actor& labelled, const Actor& found);

/// Of several found actors that match_actor() takes for a label's, the one that is it most often.
[[nodiscard]] ActorComparison compare_actors(const std::vector<Actor>& labelled,
                                             const std::vector<Actor>& found,
                                             double min_travel_m);

}  // namespace simuli
