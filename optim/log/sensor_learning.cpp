#include "optim/log/sensor_learning.hpp"

#include <utility>

#include "optim/log/own_vehicle.hpp"
#include "optim/log/range_bias.hpp"

namespace simuli {

Log with_learned_sensors(Log log, int held_out_every, const SensorLearning& what) {
  if (what.range_bias) log = with_range_bias(std::move(log), held_out_every);
  if (what.own_vehicle) log = with_blind_arcs(std::move(log), held_out_every);
  return log;
}

}  // namespace simuli
