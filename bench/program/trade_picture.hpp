#pragma once
// What `simuli bench --trade` draws.
#include <vector>

#include "bench/trade/trade.hpp"
#include "io/picture/image.hpp"

namespace simuli::bench {

/// A panel per sensor: error against the reference over frame time, both logarithmic; qualities large and
/// named, options small and numbered, with the list of numbers beside; a line through what lies on the front.
[[nodiscard]] Image trade_picture(const std::vector<TradePoint>& points);

}  // namespace simuli::bench
