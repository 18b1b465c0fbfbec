#include "host/core/base/fields.hpp"
#include "host/device/render/options/quality.hpp"
#include "optim/eval/eval_options.hpp"

namespace simuli {
namespace {

/// Defaults that an evaluation takes from the training.
struct Told {
  double image_scale = 0.0;
  int held_out_every = -1;
  double held_out_middle = -1.0;
  double held_out_last = -1.0;
  std::vector<std::string> held_out_sensors = {};
};
template <class F>
constexpr void visit_fields(Told& o, F&& field) {
  field("image_scale", o.image_scale, above(0.0, 1.0), "size of the compared pictures over the recorded");
  field("held_out_every", o.held_out_every, zero_or(at_least(2)), "every N-th frame; 0: all");
  field("held_out_middle",
        o.held_out_middle,
        range(0.0, 0.9),
        "frames of that share of the path, around its middle");
  field("held_out_last", o.held_out_last, range(0.0, 0.9), "frames of that share of the path, at its end");
  field("held_out_sensors", o.held_out_sensors, "all frames of these cameras and LiDARs");
}

}  // namespace

EvalOptions eval_options(const std::string& quality, const std::vector<std::string>& settings) {
  EvalOptions options;
  options.render = options_of(quality_of_name(quality));
  Told reported;
  Fields fields;
  fields.part("", options);
  fields.part("", reported);
  fields.apply(settings, "settings");
  if (reported.image_scale > 0.0) options.image_scale = reported.image_scale;
  if (reported.held_out_every >= 0) options.held_out_every = reported.held_out_every;
  if (reported.held_out_middle >= 0.0) options.held_out_middle = reported.held_out_middle;
  if (reported.held_out_last >= 0.0) options.held_out_last = reported.held_out_last;
  if (!reported.held_out_sensors.empty()) options.held_out_sensors = reported.held_out_sensors;
  check(options);
  return options;
}

}  // namespace simuli
