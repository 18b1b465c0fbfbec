#pragma once
// What a training is told, from the log to the scene. TrainingOptions{} are what `simuli train` takes.
#include <string>
#include <vector>

#include "io/log/frame_selection.hpp"
#include "optim/actors/finding_options.hpp"
#include "optim/complete/fixer_options.hpp"
#include "optim/init/init_options.hpp"
#include "optim/train/chunk/chunk_options.hpp"
#include "optim/train/train_options.hpp"

namespace simuli {

struct TrainingOptions {
  FrameSelection frames = {};
  bool refine_path = true;    // see with_refined_path()
  bool learn_sensors = true;  // see with_learned_sensors()
  bool find_actors = true;
  bool inpaint_behind_actors = true;
  ActorFinding actors = {};
  InitOptions init = {};
  TrainOptions train = {};
  FixerOptions fixer = {};
  ChunkOptions chunks = {};
  bool cache_initialization = true;          // for the next training, and from the one before (initialization_cache.hpp)
  std::string fixer_command = {};  // that mends pictures from beside the path (docs/FIXERS.md); empty: none
};

/// The keys that users set, with what is allowed and what it means (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(TrainingOptions& o, F&& field) {
  field.part("", o.train);
  field.part("", o.frames);
  field.group("Data");
  field("sensors.learn",
        o.learn_sensors,
        "Find the LiDARs' range biases by row, blind arcs behind the own vehicle and largest ranges first. "
        "false: the log states its LiDARs exactly.");
  field("path.refine",
        o.refine_path,
        "Train on the path on which the sweeps agree best, if they agree better than on the recorded one. "
        "false: the recorded path is exact.");
  field.part("", o.init);
  field.group("Actors");
  field(
      "actors.find",
      o.find_actors,
      "Find in the sweeps what moves and has no label, and where labels go on. false: labels are complete.");
  field.internal(o.actors);
  field("actors.inpaint",
        o.inpaint_behind_actors,
        "Fill surfaces that only actors ever hid, so that actors can be moved or removed. false: shorter end "
        "of the training, holes there.");
  field.part("", o.fixer);
  field.part("", o.chunks);
  field.internal(o.cache_initialization);
  field.internal(o.fixer_command);
}

/// The options themselves. Error{kUsage} naming the field when one is outside its range.
[[nodiscard]] TrainingOptions checked(const TrainingOptions& options);

/// Iterations for each sweep that is trained on: each of the LiDARs that training has sweeps of is due every
/// `lidar_every` iterations, and one sweep in an iteration at most. PandaSet, 20 frames, 200 iterations: beside its
/// PandarGT the Pandar64 has 1.81 cm and 0.813 of its drops found, 2.22 cm and 0.770 where they share turns.
[[nodiscard]] int iterations_a_sweep(const TrainingOptions& options, const Log& log);

/// The options of `simuli train --quality QUALITY --set SETTING...`: quality "" is balanced; settings are
/// "key=value" each. Error{kUsage} naming key, found and allowed.
[[nodiscard]] TrainingOptions training_options(const std::string& quality,
                                               const std::vector<std::string>& settings);

}  // namespace simuli
