#pragma once
// What an evaluation is told.
#include <optional>
#include <string>
#include <vector>

#include "host/core/base/allowed.hpp"
#include "host/device/render/options/options.hpp"

namespace simuli {

struct EvalOptions {
  std::optional<double> image_scale =
      {};  // of the compared pictures over the recorded; nothing: as in training
  // Nothing in all four: the frames that were not trained on. One that is there asks for a rule of its own,
  // in which the others count as 0; all 0: all frames.
  std::optional<int> held_out_every = {};                         // every N-th frame of each sensor
  std::optional<double> held_out_middle = {};                     // share of the path, around its middle
  std::optional<double> held_out_last = {};                       // share of the path, at its end
  std::optional<std::vector<std::string>> held_out_sensors = {};  // all frames of these
  int timed_renders = 5;                                          // behind a first one that warms up
  double actor_min_travel_m = 1.0;
  RenderOptions render = {};
};

/// The keys that users set, with what is allowed and what it means (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(EvalOptions& o, F&& field) {
  field.internal(o.image_scale);  // checked as those of a FrameSelection
  field.internal(o.held_out_every);
  field.internal(o.held_out_middle);
  field.internal(o.held_out_last);
  field.internal(o.held_out_sensors);
  field("timed_renders",
        o.timed_renders,
        at_least(1),
        "Renders of each sensor that are timed. More: steadier speeds, slower.");
  field("actors.least_travel_m",
        o.actor_min_travel_m,
        at_least(0.0),
        "Distance in m that an actor of the log must travel to be scored as one.");
  field.part("", o.render);
}

/// Error{kUsage} naming the key when one is outside its range.
void check(const EvalOptions& options);

}  // namespace simuli
