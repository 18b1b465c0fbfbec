#pragma once
#include "cl/shared/sensor_constants.h"
#include "host/device/runtime/device.hpp"
#include "host/device/runtime/real_buffer.hpp"

namespace simuli {

/// A camera's rendering of surfaces: its poses and the surface distances.
struct SeenSurfaces {
  SeenSurfaces(const Device& device, Precision precision)
      : sensor(device, "sensor of a recorded view", precision),
        out(device, "surfaces of a recorded view", precision) {}
  StructBuffer<shared::SensorConstants> sensor;
  RealBuffer out;  // [5][slots], as blended
};

}  // namespace simuli
