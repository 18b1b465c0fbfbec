#pragma once
// What bench/trade/trade.cpp renders: the bench street in motion, or views of a scene.
#include <memory>
#include <string>
#include <vector>

#include "bench/trade/trade.hpp"
#include "host/render/scene/renderer.hpp"
#include "host/scene/scene.hpp"
#include "host/sensors/lidar_model.hpp"

namespace simuli::bench {

/// One frame of one sensor.
struct TradeView {
  View view;
  LidarRays rays;  // of a LiDAR
  double time_s = 0.0;
};

struct TradeSensor {
  std::string name;
  bool is_camera = false;
  Camera camera;
  LidarModel lidar;
  std::vector<TradeView> views;

  [[nodiscard]] SensorRays on(const Device& device,
                              const TradeView& view,
                              const RenderOptions& options) const;
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
