#pragma once
// Options of an evaluation.
#include <optional>
#include <string>
#include <vector>

#include "host/core/base/allowed.hpp"
#include "host/device/render/options/options.hpp"

namespace simuli {

struct EvalOptions {
  std::optional<double> image_scale =
      {};  // of compared relative to recorded pictures; no value: as in training
  // Without any of these four: the frames that were not trained on. A value requests a rule of its own, in
  // which missing values are 0; all 0: all frames.
  std::optional<int> held_out_every = {};                         // every N-th frame of each sensor
  std::optional<double> held_out_middle = {};                     // share of the path, around its middle
  std::optional<double> held_out_last = {};                       // share of the path, at its end
  std::optional<std::vector<std::string>> held_out_sensors = {};  // all frames of these
  int timed_renders = 5;                                          // after a first render that warms up
  double actor_min_travel_m = 1.0;
  RenderOptions render = {};
};

/// The setting keys with allowed values and help (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(EvalOptions& o, F&& field) {
  field.internal(o.image_scale);  // checked like those of a FrameSelection
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

/// Throws Error{kUsage} with the key of an option outside its range.
void check(const EvalOptions& options);

/// Returns the options of `simuli eval --quality QUALITY --set SETTING...`: an empty quality is balanced; each
/// setting is "key=value", including "image_scale", "held_out_every", "held_out_middle" and "held_out_last".
/// Throws Error{kUsage} with key, found and allowed value.
[[nodiscard]] EvalOptions eval_options(const std::string& quality, const std::vector<std::string>& settings);

}  // namespace simuli
