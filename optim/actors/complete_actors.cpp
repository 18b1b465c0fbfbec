#include "optim/actors/complete_actors.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "optim/actors/compare_actors.hpp"

namespace simuli {
namespace {

/// A label and its found actor, before additions.
struct LabelOfFound {
  std::size_t label = 0;
  double first_s = 0.0, last_s = 0.0;
  Pose found_from_label;
};

std::vector<LabelOfFound> labels_of(const Actor& found, const std::vector<Actor>& labelled) {
  std::vector<LabelOfFound> out;
  for (std::size_t i = 0; i < labelled.size(); ++i) {
    const auto match = match_actor(labelled[i], found);
    if (!match) continue;
    const Pose label_from_found{
        Eigen::Quaterniond(Eigen::AngleAxisd(match->turned_rad, Eigen::Vector3d::UnitZ())), match->offset_m};
    const std::vector<KeyPose>& track = labelled[i].track;
    out.push_back({i, track.front().time_s, track.back().time_s, label_from_found.inverse()});
  }
  return out;
}

/// Half of the shortest key interval: tolerance at a label's ends.
double half_period_s(const Actor& actor) {
  double least_s = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < actor.track.size(); ++k)
    least_s = std::min(least_s, actor.track[k].time_s - actor.track[k - 1].time_s);
  return 0.5 * least_s;
}

/// The label that continues at that time; null when a label covers it.
const LabelOfFound* going_on(const std::vector<LabelOfFound>& labels, double time_s, double apart_s) {
  const LabelOfFound* nearest = nullptr;
  double nearest_s = std::numeric_limits<double>::infinity();
  for (const LabelOfFound& label : labels) {
    const double away_s = std::max(label.first_s - time_s, time_s - label.last_s);
    if (away_s < apart_s) return nullptr;
    if (away_s < nearest_s) {
      nearest_s = away_s;
      nearest = &label;
    }
  }
  return nearest;
}

std::string free_name(const std::vector<Actor>& actors, std::size_t& number) {
  for (;; ++number) {
    std::string name = fmt::format("moving_{}", number);
    if (!has_actor(actors, name)) return name;
  }
}

}  // namespace

CompletedActors complete_actors(std::vector<Actor> labelled, const FoundActors& found) {
  std::erase_if(labelled, [&](const Actor& label) {
    return std::find(found.standing.begin(), found.standing.end(), label.name) != found.standing.end();
  });
  CompletedActors out;
  out.actors = labelled;
  std::vector<bool> is_continued(labelled.size(), false);
  std::size_t number = 0;
  for (const Actor& actor : found.actors) {
    const std::vector<LabelOfFound> labels = labels_of(actor, labelled);
    if (labels.empty()) {
      out.actors.push_back(actor);
      out.actors.back().name = free_name(labelled, number);
      ++number;
      ++out.added;
      continue;
    }
    const double apart_s = half_period_s(actor);
    for (const KeyPose& key : actor.track) {
      const LabelOfFound* label = going_on(labels, key.time_s, apart_s);
      if (label == nullptr) continue;
      std::vector<KeyPose>& track = out.actors[label->label].track;
      const auto place = std::lower_bound(
          track.begin(), track.end(), key.time_s, [](const KeyPose& k, double t) { return k.time_s < t; });
      if (place != track.end() && place->time_s == key.time_s) continue;  // from another found actor
      KeyPose added;
      added.time_s = key.time_s;
      added.world_from_actor = key.corrected() * label->found_from_label;
      track.insert(place, added);
      is_continued[label->label] = true;
    }
  }
  out.continued = static_cast<std::size_t>(std::count(is_continued.begin(), is_continued.end(), true));
  return out;
}

}  // namespace simuli
