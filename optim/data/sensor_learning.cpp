#include "optim/data/sensor_learning.hpp"

#include <utility>

namespace simuli {

Log with_learned_sensors(Log log, const FrameSelection& frames) {
  log = with_range_bias(std::move(log), frames);
  log = with_blind_arcs(std::move(log), frames);
  return with_range_limit(std::move(log), frames);
}

}  // namespace simuli
