#include "io/log/label_tracks.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <set>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/spread.hpp"

namespace simuli {
namespace {

std::string numbered_name(const std::string& kind, std::size_t number) {
  std::string name = name_from(fmt::format("{}_{}", kind.substr(kind.rfind('.') + 1), number));
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
    return c == ' ' ? '_' : static_cast<char>(std::tolower(c));
  });
  return name;
}

}  // namespace

void LabelTracks::add(const std::string& id,
                      const std::string& kind,
                      const KeyPose& key,
                      const Eigen::Vector3d& size_m,
                      const std::string& name) {
  const auto [entry, is_new] = index_.emplace(id, tracks_.size());
  if (is_new) {
    tracks_.emplace_back();
    tracks_.back().actor.name = name.empty() ? numbered_name(kind, entry->second) : name;
    tracks_.back().actor.kind = kind;
  }
  Track& track = tracks_[entry->second];
  for (int side = 0; side < 3; ++side) track.sizes_m[side].push_back(size_m[side]);
  track.actor.track.push_back(key);
}

std::vector<Actor> LabelTracks::take(const std::string& file, LabelReport& report) {
  std::vector<Actor> actors;
  std::set<std::string> names;
  for (Track& track : tracks_) {
    Actor& actor = track.actor;
    const std::string name = actor.name;
    for (std::size_t n = 2; !names.insert(actor.name).second; ++n)
      actor.name = fmt::format("{}_{}", name.substr(0, 100), n);
    for (int side = 0; side < 3; ++side) actor.size_m[side] = upper_median(std::move(track.sizes_m[side]));
    std::vector<KeyPose>& keys = actor.track;
    std::stable_sort(
        keys.begin(), keys.end(), [](const KeyPose& a, const KeyPose& b) { return a.time_s < b.time_s; });
    const auto end = std::unique(
        keys.begin(), keys.end(), [](const KeyPose& a, const KeyPose& b) { return a.time_s == b.time_s; });
    report.repeated += static_cast<std::size_t>(keys.end() - end);
    keys.erase(end, keys.end());
    report.kept += keys.size();
    validate(actor, file);
    actors.push_back(std::move(actor));
  }
  return actors;
}

}  // namespace simuli
