#pragma once
#include "host/base/allowed.hpp"

namespace simuli {

/// How the shapes of actors that are not rigid are learned: people, and who rides what has no cabin.
struct ShapeRates {
  bool learn = true;
  double rate_m = 0.01;
  double final_share = 0.1;
  double interval_s = 0.1;
  double smooth = 0.01;
};
template <class F>
constexpr void visit_fields(ShapeRates& o, F&& field) {
  field("actors.shape.learn",
        o.learn,
        "learn how people and riders change their shape: those that labels call so, and what is found and as "
        "large; false: all actors are rigid");
  field("actors.shape.rate_m", o.rate_m, at_least(0.0), "m per step of Adam, of shapes, at the start");
  field("actors.shape.final_share", o.final_share, above(0.0, 1.0), "of it, at the end");
  field("actors.shape.interval_s",
        o.interval_s,
        range(0.02, 10.0),
        "s between knots in time, half a swing of a leg or less");
  field("actors.shape.smooth",
        o.smooth,
        range(0.0, 0.5),
        "of its distance to the mean of its neighbours, in space and time, by which each offset goes there "
        "per step that moves it");
}

}  // namespace simuli
