#pragma once
#include "host/device/runtime/device.hpp"

namespace simuli::test {

/// Returns the device of a test program, opened once so that kernels are compiled once. Tests that measure
/// memory or compilations open their own device.
inline const Device& device() {
  static const Device* const opened =
      new Device(Device::best());  // never closed: drivers may be unloaded before
  return *opened;
}

}  // namespace simuli::test
