#pragma once
#include "host/device/runtime/device.hpp"

namespace simuli::test {

/// The device of a test program, opened once, so that each program of its kernels is built once, too. Who
/// measures memory or builds opens one of its own.
inline const Device& device() {
  static const Device* const opened =
      new Device(Device::best());  // never closed: drivers may be gone by then
  return *opened;
}

}  // namespace simuli::test
