#pragma once
// What bench/trade/trade.cpp renders: the bench street in motion, or views of a scene.
#include <memory>
#include <string>
#include <vector>

#include "bench/trade/trade.hpp"
#include "host/core/scene/scene.hpp"
#include "host/core/sensors/sensor.hpp"
#include "host/device/render/scene/shot.hpp"

namespace simuli::bench {

/// One frame of one sensor; a LiDAR with the rays of that frame.
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

/// The bench street, 200 000 particles a set: a 640 x 360 camera with a read-out of 20 ms and generic64, both
/// at 15 m/s and 20 degrees/s.
[[nodiscard]] TradeScene moving_street();
/// Views of `folders`, see TradeOptions. Errors of run_trade().
[[nodiscard]] TradeScene trade_scene(const TradeOptions& options);

}  // namespace simuli::bench
