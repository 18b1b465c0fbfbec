#pragma once
// Views for bench/trade/trade.cpp: the bench street in motion, or views of a scene.
#include <memory>
#include <string>
#include <vector>

#include "bench/trade/trade.hpp"
#include "host/core/scene/scene.hpp"
#include "host/core/sensors/sensor.hpp"
#include "host/device/render/scene/shot.hpp"

namespace simuli::bench {

/// One frame of a sensor; a LiDAR has the rays of this frame.
struct TradeView {
  Sensor sensor;
  Shot shot;
};

struct TradeSensor {
  std::string name;
  bool is_camera = false;
  std::vector<TradeView> views;
};

struct TradeScene {
  Scene scene;
  std::vector<TradeSensor> sensors;
};

/// Returns the bench street with 200 000 particles per set: a 640 x 360 camera with a readout of 20 ms and a
/// generic64, both at 15 m/s and 20 degrees/s.
[[nodiscard]] TradeScene moving_street();
/// Returns views of `folders` (TradeOptions). Throws the errors of run_trade().
[[nodiscard]] TradeScene trade_scene(const TradeOptions& options);

}  // namespace simuli::bench
