#pragma once
// Actors from labelled boxes, by one rule for all importers.
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// Counts the labels of a drive.
struct LabelReport {
  std::size_t kept = 0;      // labels in the tracks of the log's actors
  std::size_t repeated = 0;  // labels left out because their actor has an earlier one at the same time
};

/// Collects the labels of a drive by object and returns one actor per object.
class LabelTracks {
 public:
  /// Adds a label of the object `id`. The object's first label sets the kind and the name of the actor. Without a
  /// name it is the last part of the kind and the number of the object: "vehicle.car" becomes "car_3".
  void add(const std::string& id,
           const std::string& kind,
           const KeyPose& key,
           const Eigen::Vector3d& size_m,
           const std::string& name = {});

  /// Returns the actors in the order of their first labels and adds to `report`. An actor's size is the
  /// component-wise median over its labels, which differ from each other; its poses are in time order, and of several
  /// labels at one time the first is kept. Names that two actors would share get a number. Error{kInput} naming `file`
  /// for an actor that validate() refuses.
  [[nodiscard]] std::vector<Actor> take(const std::string& file, LabelReport& report);

 private:
  struct Track {
    Actor actor;
    std::vector<double> sizes_m[3];
  };
  std::map<std::string, std::size_t> index_;  // by id
  std::vector<Track> tracks_;
};

}  // namespace simuli
