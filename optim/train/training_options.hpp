#pragma once
// What a training is told, from the log to the scene. TrainingOptions{} are what `simuli train` takes.
#include <string>
#include <vector>

#include "io/log/frame_selection.hpp"
#include "optim/actors/finding_options.hpp"
#include "optim/fill/fill_options.hpp"
#include "optim/fixer/fixer_options.hpp"
#include "optim/init/init_options.hpp"
#include "optim/log/sensor_learning.hpp"
#include "optim/path/path_options.hpp"
#include "optim/stretch/stretch_options.hpp"
#include "optim/train/train_options.hpp"

namespace simuli {

struct TrainingOptions {
  FrameSelection frames = {};
  PathRefinement path = {};
  SensorLearning sensors = {};
  ActorFinding actors = {};
  FillOptions fill = {};
  InitOptions init = {};
  TrainOptions train = {};
  FixerOptions fixer = {};
  StretchOptions stretches = {};
  std::string fixer_command = {};  // that mends pictures from beside the path (docs/FIXERS.md); empty: none
};

/// The keys that users set, with what is allowed and what it means (host/base/fields.hpp).
template <class F>
constexpr void visit_fields(TrainingOptions& o, F&& field) {
  field.part("", o.frames);
  field.part("", o.path);
  field.part("", o.sensors);
  field.part("", o.actors);
  field.part("", o.fill);
  field.part("", o.init);
  field.part("", o.train);
  field.part("", o.fixer);
  field.part("", o.stretches);
  field.keyless(o.fixer_command);
}

/// The options themselves. Error{kUsage} naming the field when one is outside its range.
[[nodiscard]] TrainingOptions checked(const TrainingOptions& options);

/// The options of `simuli train --quality QUALITY --set SETTING...`: quality "" is balanced; settings are
/// "key=value" each. Error{kUsage} naming key, found and allowed.
[[nodiscard]] TrainingOptions training_options(const std::string& quality,
                                               const std::vector<std::string>& settings);

}  // namespace simuli
