#pragma once
// Options of a training from log to scene. TrainingOptions{} are the defaults of `simuli train`.
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
  bool cache_initialization = true;  // read and write the initialisation cache (initialization_cache.hpp)
  std::string fixer_command =
      {};  // program that repairs off-trajectory pictures (docs/FIXERS.md); empty: none
};

/// The setting keys with allowed values and help (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(TrainingOptions& o, F&& field) {
  field.part("", o.train);
  field.part("", o.frames);
  field.group("Data");
  field("sensors.learn",
        o.learn_sensors,
        "Find the LiDARs' range biases by row, blind arcs of the ego vehicle and largest ranges first. "
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
      "Find unlabelled moving objects in the sweeps, and extend labels in time. false: labels are complete.");
  field.internal(o.actors);
  field("actors.inpaint",
        o.inpaint_behind_actors,
        "Inpaint surfaces that actors occlude in all frames, so that actors can be moved or removed. "
        "false: shorter end of the training, holes there.");
  field.part("", o.fixer);
  field.part("", o.chunks);
  field.internal(o.cache_initialization);
  field.internal(o.fixer_command);
}

/// Returns the options. Throws Error{kUsage} with the key of an option outside its range.
[[nodiscard]] TrainingOptions checked(const TrainingOptions& options);

/// Returns the iterations per training sweep: each LiDAR with training sweeps is due every `lidar_every`
/// iterations, with at most one sweep per iteration (docs/DECISIONS.md, "LiDAR set").
[[nodiscard]] int iterations_a_sweep(const TrainingOptions& options, const Log& log);

/// Returns the options of `simuli train --quality QUALITY --set SETTING...`: an empty quality is balanced; each
/// setting is "key=value". Throws Error{kUsage} with key, found and allowed value.
[[nodiscard]] TrainingOptions training_options(const std::string& quality,
                                               const std::vector<std::string>& settings);

}  // namespace simuli
